"""Drivers of what hangs on a cable of its own beside the robot's: one module each. See `cable`."""

"""Accessories of a robot: devices without port and clock. See `p2os_emu.device`."""

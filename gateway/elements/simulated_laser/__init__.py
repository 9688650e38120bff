"""The laser that a simulator sends on the robot's line."""

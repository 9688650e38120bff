"""The arm on the robot's own controller."""

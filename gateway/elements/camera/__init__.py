"""A camera beside the robot's line."""

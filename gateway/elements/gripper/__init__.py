"""The gripper."""

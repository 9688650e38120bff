"""Scenes: short demonstrations of one feature of a robot. See `stage`."""

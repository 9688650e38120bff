"""Scenes: a robot with something special, and a few seconds in which one sees it at work. See `stage`."""

"""Cameras of a robot, which are no part of its cable: an IP camera at a URL, or a device of this computer."""

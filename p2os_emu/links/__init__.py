"""The robot's cable: the ports a client opens, and the line between port and firmware."""

"""What the commands of the Pioneer arm and its ARMpac carry. Source: fact sheet of accessories, section 5."""

JOINTS = 6
EVERY_JOINT = 255
"""Argument of HOME and STOP that means all of them, by the manual."""
MS = 0.001
"""s; servos take so many ms a count."""
LONGEST_MS = 127
"""The most that SPEED carries, ms a count."""
MANUAL_POWERED, MANUAL_CONNECTED = 1, 2
"""Bits of the first byte where a controller sends the bytes of ARMpac in the manual's order."""

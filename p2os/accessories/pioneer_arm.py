"""Values of the Pioneer arm's commands and its ARMpac. Source: fact sheet of accessories, section 5."""

JOINTS = 6
GRIPPER_JOINT = 6
EVERY_JOINT = 255
"""Argument of HOME and STOP that means all joints, by the manual."""
ALL_JOINTS = frozenset({0, 7, EVERY_JOINT})
"""Arguments of HOME and STOP that mean all joints; a well-known driver sends 7."""
NO_ARM = "No arm"
"""Version in the ARMINFOpac of a robot without arm."""
MS = 0.001
"""s; servos take so many ms a count."""
LONGEST_MS = 127
"""The most that SPEED carries, ms a count."""
MANUAL_POWERED, MANUAL_CONNECTED = 1, 2
"""Bits of the first byte where a controller sends the bytes of ARMpac in the manual's order."""

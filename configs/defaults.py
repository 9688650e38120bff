"""Names of files in this package that programs use when nothing else is given."""

ROBOT = "p3dx-sh"
"""The most common robot: what a robot is taken for until it names its model."""
TEST_ROBOT = "p3dx"
WORLD = "office"
EMPTY_WORLD = "empty"
LINK = "ideal"

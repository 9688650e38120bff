"""The PowerBot's arm of PowerCube modules, on a line of its own."""

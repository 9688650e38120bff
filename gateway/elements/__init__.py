"""The elements of a robot: a folder for each, with the driver's side and the bus adapter."""

"""The head that points a camera: pan, tilt and zoom."""

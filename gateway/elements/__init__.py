"""The elements of a robot that hang on its microcontroller: one module each. See `element`."""

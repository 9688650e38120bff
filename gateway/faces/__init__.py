"""What the elements look like from the bus: one module each. See `face`."""

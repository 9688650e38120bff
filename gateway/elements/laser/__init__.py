"""A SICK LMS 2xx on a line of its own."""

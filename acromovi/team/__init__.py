"""A team as processes: which there are, how they begin, are kept going, and end in order. See `team`."""

"""A team as processes: planned, started, supervised and ended in order. See `team`."""

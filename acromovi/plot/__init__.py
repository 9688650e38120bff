"""`acromovi plot`: pictures of a recording. See `command`."""

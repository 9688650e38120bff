"""Elements on cables of their own: the protocols of their drivers, and their threads."""

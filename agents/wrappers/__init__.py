"""Native programs and libraries as agents."""

"""Recordings of the bus in MCAP files: written, read, and published again. See `recording` and `playback`."""

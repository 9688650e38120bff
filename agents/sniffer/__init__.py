"""Messages between agents as containers publish them: read, filtered, and sorted by time."""

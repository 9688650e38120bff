"""The container: the process that hosts agents, its interface for them, and its control over the bus."""

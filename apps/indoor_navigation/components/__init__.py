"""The components as agents: each takes data, calls an algorithm, and pushes the result."""

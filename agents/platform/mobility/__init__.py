"""Agents that move from one container to another with their state."""

"""Agents for every element of every robot: a platform, components, services and wrappers, on the bus."""

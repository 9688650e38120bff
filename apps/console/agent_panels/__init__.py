"""The panels of the page Agents."""

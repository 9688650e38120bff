"""Accessories: their models, and the protocols of those with a line of their own, for both ends. No port, no clock."""

"""Accessories: what they are, and what they say on cables of their own, for both ends. No port, no clock."""

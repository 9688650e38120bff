"""Localization on the map of a building: Monte-Carlo localization, search from an unknown start, and doubt."""

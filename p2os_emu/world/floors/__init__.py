"""Floors made up by a seed: a module for each family, and what they share."""

"""The compass module."""

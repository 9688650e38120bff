"""Infrared range sensors."""

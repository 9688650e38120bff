"""Emulated Pioneer and PowerBot robots: firmware, a world of physics, and a cable that any existing client can open."""

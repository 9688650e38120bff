"""Captured messages between agents: read, sorted, and drawn as sequence diagrams in text and SVG."""

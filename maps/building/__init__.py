"""Building a map from readings: scan matching, pose graph, occupancy grids, and lines fitted to what was seen.

Readings and poses in, maps out: no bus, no port, no clock. This file loads nothing.
"""

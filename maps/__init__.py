"""Maps of buildings: files, occupancy grids, building a map from readings, and localization on one.

Arrays and numbers in, arrays and numbers out: no bus, no port, no clock. Lengths in m, angles in rad; a map has the
frame `map`. The modules load numpy, so a program imports them where it uses them. This file loads nothing.
"""

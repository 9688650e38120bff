"""Path planning: the grid and the map of doors, costs, ways, and decisions during a mission."""

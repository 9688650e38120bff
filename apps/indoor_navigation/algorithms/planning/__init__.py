"""How a mission is planned: what was seen, what it costs to go there, the way, and what is done when it is barred."""

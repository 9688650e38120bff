"""A base and a laser for a robot that is not a Pioneer: a disc among straight walls, without physics.

It shows that the navigation is portable: the wiring names two other components, and the rest is unchanged.
"""

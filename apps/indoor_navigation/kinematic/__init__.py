"""A base and a laser for a robot that is no Pioneer: a disc that rolls among walls which are lines, without physics.

It is here to prove that the navigation is portable: two lines of the wiring are changed, and no other component knows.
"""

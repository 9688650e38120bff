"""Agents for every element of every robot: a platform, components, services and wrappers, on the bus.

What a program needs that drives robots is here; all else is in the packages beneath.
"""

from agents.face import Failed, NotThere, Refused, Robot, RobotError, Stopped, Team, TimedOut, request

__all__ = ["Failed", "NotThere", "Refused", "Robot", "RobotError", "Stopped", "Team", "TimedOut", "request"]

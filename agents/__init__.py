"""Agents for every element of every robot: a platform, components, services and wrappers, on the bus.

What a program needs that drives robots is here; all else is in the packages beneath. It is loaded when it is asked for,
so that a container does not carry what only programs use.
"""

from typing import TYPE_CHECKING

__all__ = [
    "Failed",
    "LeaseLost",
    "NotThere",
    "Refused",
    "Robot",
    "RobotError",
    "Stopped",
    "Team",
    "TimedOut",
    "request",
]

if TYPE_CHECKING:
    from agents.face import Failed, LeaseLost, NotThere, Refused, Robot, RobotError, Stopped, Team, TimedOut, request
else:

    def __getattr__(name: str) -> object:
        """Load the face on its first use (PEP 562)."""
        if name not in __all__:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        from agents import face

        globals().update({each: getattr(face, each) for each in __all__})
        return globals()[name]

    def __dir__() -> list[str]:
        return sorted({*globals(), *__all__})

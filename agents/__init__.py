"""Agents for every element of every robot: a platform, components, services and wrappers, on the bus.

Exports what a program needs to drive robots (`Team`, from `agents.client`) and what an agent needs (`Agent` and its
decorators, from `agents.platform`). Each is loaded on its first use, so that a container does not load the client.
"""

from typing import TYPE_CHECKING

__all__ = [
    "Agent",
    "Failed",
    "LeaseLost",
    "NotThere",
    "Refused",
    "Robot",
    "RobotError",
    "Stopped",
    "Team",
    "TimedOut",
    "every",
    "on",
    "request",
    "subscription",
]

if TYPE_CHECKING:
    from agents.client import Failed, LeaseLost, NotThere, Refused, Robot, RobotError, Stopped, Team, TimedOut
    from agents.platform import Agent, every, on, request, subscription
else:
    _OF_PLATFORM = {"Agent", "every", "on", "request", "subscription"}

    def __getattr__(name: str) -> object:
        """Load a name on its first use (PEP 562)."""
        if name not in __all__:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        from importlib import import_module

        value = getattr(import_module("agents.platform" if name in _OF_PLATFORM else "agents.client"), name)
        globals()[name] = value
        return value

    def __dir__() -> list[str]:
        return sorted({*globals(), *__all__})

"""Agents for every element of every robot: a platform, components, services and wrappers, on the bus.

Exports what a program needs to drive robots (`Team` and what its methods return and raise) and what an agent needs
most (`Agent` and its decorators; `agents.platform` has the rest). Each name is loaded on its first use, so that a
container does not load the client.
"""

from typing import TYPE_CHECKING

__all__ = [
    "Agent",
    "ElementClient",
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
    from agents.client.element import ElementClient
    from agents.client.errors import Failed, LeaseLost, NotThere, RobotError, Stopped
    from agents.client.errors import RequestRefused as Refused
    from agents.client.errors import RequestTimedOut as TimedOut
    from agents.client.robot import Robot
    from agents.client.team import Team
    from agents.platform import Agent, every, on, request, subscription
else:
    _PLATFORM = {"Agent", "every", "on", "request", "subscription"}
    _MODULES = {"ElementClient": "agents.client.element", "Robot": "agents.client.robot", "Team": "agents.client.team"}
    _OWN_NAMES = {"Refused": "RequestRefused", "TimedOut": "RequestTimedOut"}

    def __getattr__(name: str) -> object:
        """Load a name on its first use (PEP 562)."""
        if name not in __all__:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        from importlib import import_module

        module = "agents.platform" if name in _PLATFORM else _MODULES.get(name, "agents.client.errors")
        value = getattr(import_module(module), _OWN_NAMES.get(name, name))
        globals()[name] = value
        return value

    def __dir__() -> list[str]:
        return sorted({*globals(), *__all__})

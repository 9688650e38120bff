"""The gateway: a driver for one robot on a serial line, which publishes it on the bus.

Exports what a Python program needs to run `p2os-gateway` as a child process, and the settings that its `--config`
file holds. The robot is used through the bus:

    import gateway

    with gateway.start("/dev/ttyUSB0", name="happy", bus="local") as running:
        print(running.model)
"""

from typing import TYPE_CHECKING

__all__ = [
    "Calibration",
    "CameraSettings",
    "DriveLimits",
    "Fitted",
    "GatewayError",
    "LaserSettings",
    "LaserUnit",
    "OdometryErrors",
    "PtzChoice",
    "RunningGateway",
    "Settings",
    "load_settings",
    "start",
]

if TYPE_CHECKING:
    from gateway.errors import GatewayError
    from gateway.program import RunningGateway, start
    from gateway.settings import (
        Calibration,
        CameraSettings,
        DriveLimits,
        Fitted,
        LaserSettings,
        LaserUnit,
        OdometryErrors,
        PtzChoice,
        Settings,
        load_settings,
    )
else:
    _MODULES = {"GatewayError": "errors", "RunningGateway": "program", "start": "program"}

    def __getattr__(name: str) -> object:
        """Load a name on its first use (PEP 562), so that no program loads what it does not use."""
        if name not in __all__:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        from importlib import import_module

        value = getattr(import_module(f"gateway.{_MODULES.get(name, 'settings')}"), name)
        globals()[name] = value
        return value

    def __dir__() -> list[str]:
        return sorted({*globals(), *__all__})

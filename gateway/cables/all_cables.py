"""Every element that may hang on a cable of its own: how its driver is made."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from configs import load
from gateway.cables.cable import ElementDriver
from gateway.settings import Settings
from p2os.accessories.arm_model import ArmModel


@dataclass(frozen=True, slots=True)
class CablePart:
    """One kind of element.

    help: of the option that names its port. make: its driver, from whether the port has a rate and the settings; raises
    ConfigError where these want what there is not.
    """

    help: str
    make: Callable[[bool, Settings], ElementDriver]


def _laser(has_rate: bool, settings: Settings) -> ElementDriver:
    from gateway.elements.laser.driver import (
        LaserDriver,  # here and not at the top: a gateway without one starts sooner
    )

    return LaserDriver(settings.laser, has_rate=has_rate)


def _arm(has_rate: bool, settings: Settings) -> ElementDriver:
    from gateway.elements.powercube.driver import PowerCubeDriver  # likewise

    return PowerCubeDriver(load(ArmModel, "accessories", "powercube-arm"), has_rate=has_rate)


CABLES: Mapping[str, CablePart] = {
    "laser": CablePart("a SICK LMS 2xx on a port of its own: a device or a URL", _laser),
    "arm": CablePart("the PowerBot's arm of PowerCube modules on a port of its own: a device or a URL", _arm),
}
"""By name; `p2os-gateway --NAME PORT` opens the port."""

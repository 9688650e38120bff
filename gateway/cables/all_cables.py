"""Every element that may hang on a cable of its own: how its driver is made. The faces are in `gateway.faces`."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from gateway.cables.cable import ElementDriver
from gateway.settings import Settings


@dataclass(frozen=True, slots=True)
class CablePart:
    """One kind of element.

    help: of the option that names its port. make: its driver, from whether the port has a rate and the settings.
    """

    help: str
    make: Callable[[bool, Settings], ElementDriver]


CABLES: Mapping[str, CablePart] = {}
"""By name; `p2os-gateway --NAME PORT` opens the port."""

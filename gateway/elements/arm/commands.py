"""The orders of `command/arm` for every kind of arm: parsing, limits, refusals."""

from collections.abc import Mapping, Sequence
from math import isfinite
from typing import Any, Protocol

from bus.validation import quoted
from gateway.commands import TOKEN, Arguments, check_arguments
from gateway.driver import Driver
from gateway.elements.arm.joint_limits import JointLimits
from gateway.errors import CommandRefused

TOLERANCE = 1e-3
"""rad or m by which a target may lie beyond a limit: what people round."""
MOST_DIGITS = 3
"""Of a joint's number."""
ORDERS: Mapping[str, tuple[dict[str, type], dict[str, type]]] = {
    "move": ({"joints": dict}, {"speed": float}),
    "home": ({}, {}),
    "park": ({}, {}),
    "stop": ({}, {}),
    "power": ({"on": bool}, {}),
}
"""What each order takes, and may take."""
MAY_TAKE: Mapping[str, type] = {"joints": dict, "speed": float, "on": bool}


class Reaching(Protocol):
    """An arm that takes orders; joints count from 0. It refuses with CommandRefused what it cannot do now."""

    @property
    def limits(self) -> Sequence[JointLimits]:
        """The limits of every joint."""
        ...

    def move(self, targets: Mapping[int, float], speed: float | None, now: float) -> None:
        """Send joints to their targets, rad (m), each turning one at `speed`, rad/s; at its usual one if None."""
        ...

    def home(self, now: float) -> None:
        """Send every joint home."""
        ...

    def park(self, now: float) -> None:
        """Send every joint home, then take the power off."""
        ...

    def duration(self, targets: Mapping[int, float] | None, speed: float | None) -> float:
        """Return the expected duration until the joints are at their targets, s; home if None."""
        ...

    def halt(self, now: float) -> None:
        """Stop every joint where it is."""
        ...

    def switch(self, on: bool, now: float) -> None:
        """Switch the power."""
        ...


def order(arm: Reaching, driver: Driver, arguments: Arguments, now: float) -> None:
    """Carry out an order.

    Args:
        arm: Which.
        driver: Of the robot that carries the arm.
        arguments: As they came, the lease's token among them.
        now: Steady time, s.
    Raises:
        CommandRefused: It is no order, asks for more than the arm can do, or the e-stop is latched.
    """
    what = arguments["do"]
    if what not in ORDERS:
        raise CommandRefused(f"an arm cannot {what!r}; use {', '.join(ORDERS)}")
    rest = {key: value for key, value in arguments.items() if key not in ("do", TOKEN)}
    given = check_arguments(f"arm {what}", rest, *ORDERS[what])
    if what != "stop":
        driver.check_free()
    match what:
        case "move":
            speed = given.get("speed")
            pace = None if speed is None else _speed(speed, arm.limits)
            arm.move(_targets(given["joints"], arm.limits), pace, now)
        case "home":
            arm.home(now)
        case "park":
            arm.park(now)
        case "stop":
            arm.halt(now)
        case "power":
            arm.switch(given["on"], now)


def duration(arm: Reaching, arguments: Arguments) -> float:
    """Return the expected duration of an order, s; 0 for one that moves nothing, or is none.

    Raises:
        CommandRefused: A joint or its target is not one of this arm's.
    """
    if not arm.limits:
        return 0.0  # it is not known yet, and refuses the order
    match arguments:
        case {"do": "move", "joints": joints}:
            speed = arguments.get("speed")
            return arm.duration(_targets(joints, arm.limits), None if speed is None else _speed(speed, arm.limits))
        case {"do": "home" | "park"} | {"do": "power", "on": False}:
            return arm.duration(None, None)
    return 0.0


def describe(limits: Sequence[JointLimits], names: Sequence[str]) -> list[dict[str, Any]]:
    """Return the joints for a description: limits, speed and home in the unit given."""
    return [
        {
            "name": name,
            "unit": each.unit,
            "lower": each.lower,
            "upper": each.upper,
            "speed": each.fastest,
            "home": each.home,
        }
        for name, each in zip(names, limits, strict=True)
    ]


def _targets(joints: Mapping[str, Any], limits: Sequence[JointLimits]) -> dict[int, float]:
    if not joints:
        raise CommandRefused('arm move needs joints, such as {"1": 0.5}')
    return dict(_target(name, place, limits) for name, place in joints.items())


def _target(name: str, place: Any, limits: Sequence[JointLimits]) -> tuple[int, float]:
    number = int(name) if name.isascii() and name.isdecimal() and len(name) <= MOST_DIGITS else 0
    if not 1 <= number <= len(limits):
        raise CommandRefused(f"the arm has no joint {quoted(name)}; its joints are 1 to {len(limits)}")
    one = limits[number - 1]
    if isinstance(place, bool) or not isinstance(place, int | float) or not isfinite(place):
        raise CommandRefused(f"joint {number} needs a number, {one.unit}, not {quoted(place)}")
    if not one.lower - TOLERANCE <= place <= one.upper + TOLERANCE:
        raise CommandRefused(
            f"joint {number} goes from {one.lower:.4g} to {one.upper:.4g} {one.unit}, and not to {place:.4g}"
        )
    return number - 1, min(max(float(place), one.lower), one.upper)


def _speed(speed: float, limits: Sequence[JointLimits]) -> float:
    turning = [each for each in limits if not each.slides]
    slowest, fastest = max(each.slowest for each in turning), min(each.fastest for each in turning)
    if not slowest <= speed <= fastest + TOLERANCE:
        raise CommandRefused(f"the joints turn at {slowest:.3g} to {fastest:.4g} rad/s, and not at {speed:.4g}")
    return min(speed, fastest)

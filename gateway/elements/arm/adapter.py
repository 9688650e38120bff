"""The arm on the bus: messages, and the orders of `command/arm` with their limits and refusals.

An arm on the robot's line and one on a cable of its own have the same keys.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from math import isfinite
from typing import Any, Protocol, TypeVar

import numpy as np

from bus import keys
from bus.keys import Topic, frame
from bus.messages import Arm, JointState, header
from bus.validation import quoted
from gateway.commands import TOKEN, Arguments, CommandRow, check_arguments
from gateway.elements.adapter import BusAdapter
from gateway.elements.arm.element import ArmElement
from gateway.elements.arm.joint_limits import JointLimits
from gateway.errors import CommandRefused
from gateway.events import ArmSeen
from p2os.accessories.arm_model import ArmModel

T = TypeVar("T")

_TOLERANCE = 1e-3
"""rad or m by which a target may lie beyond a limit: what people round."""
_MOST_DIGITS = 3
"""Of a joint's number."""
_ORDERS: Mapping[str, tuple[dict[str, type], dict[str, type]]] = {
    "move": ({"joints": dict}, {"speed": float}),
    "home": ({}, {}),
    "park": ({}, {}),
    "stop": ({}, {}),
    "power": ({"on": bool}, {}),
}
"""What each order takes, and may take."""
_MAY_TAKE: Mapping[str, type] = {"joints": dict, "speed": float, "on": bool}


class ArmCommands(Protocol):
    """An arm that takes orders; joints count from 0. It refuses with CommandRefused what it cannot do now."""

    @property
    def limits(self) -> Sequence[JointLimits]:
        """The limits of every joint."""

    @property
    def model(self) -> ArmModel:
        """The model that it is taken for: the robot does not tell lengths."""

    def move(self, targets: Mapping[int, float], speed: float | None, now: float) -> None:
        """Send joints to their targets, rad (m), each turning one at `speed`, rad/s; at its usual one if None."""

    def home(self, now: float) -> None:
        """Send every joint home."""

    def park(self, now: float) -> None:
        """Send every joint home, then take the power off."""

    def duration(self, targets: Mapping[int, float] | None, speed: float | None) -> float:
        """Return the expected duration until the joints are at their targets, s; home if None."""

    def halt(self, now: float) -> None:
        """Stop every joint where it is."""

    def switch(self, on: bool, now: float) -> None:
        """Switch the power."""


class ArmAdapter(BusAdapter[ArmSeen]):
    """`<robot>/arm`, its joints among `<robot>/joint_states`, and `command/arm`.

    The joints are `<robot>/arm_joint_1` and so on; that of a gripper is the last.
    """

    name = "arm"
    streams = (keys.ARM, keys.JOINT_STATES)
    events = (ArmSeen,)
    element = ArmElement

    def messages(self, event: ArmSeen, stamp: int) -> Iterable[tuple[Topic, object]]:
        """Return two messages for each report of the arm."""
        base = header(stamp, frame(self._robot, "base_link"))
        yield keys.ARM, Arm(base, event.powered, event.homed, event.moving)
        joints = JointState(
            header=base,
            name=self._joint_names(len(event.positions)),
            position=np.array(event.positions),
            velocity=np.array([]),
            effort=np.array([]),
        )
        yield keys.JOINT_STATES, joints

    def describe(self) -> Mapping[str, Any]:
        """Return limits, speed and home of the joints, as the arm reports them, and its chain of joints."""
        names = self._joint_names(len(self._limits))
        joints = [
            {
                "name": name,
                "unit": each.unit,
                "lower": each.lower,
                "upper": each.upper,
                "speed": each.fastest,
                "home": each.home,
            }
            for name, each in zip(names, self._limits, strict=True)
        ]
        return {"joints": joints, "chain": _chain(self._arm_model)}

    @property
    def _arm_model(self) -> ArmModel:
        return self._driver.lookup(ArmElement).model

    @property
    def _limits(self) -> Sequence[JointLimits]:
        return self._driver.lookup(ArmElement).limits

    def _call(self, call: Callable[[ArmCommands, float], T], now: float) -> T:
        """Call a function with the arm and the steady time of its line, s.

        Raises:
            CommandRefused: There is no arm, or the function refuses.
        """
        return call(self._driver.element(ArmElement, now), now)

    def _joint_names(self, count: int) -> list[str]:
        return [frame(self._robot, f"arm_joint_{number}") for number in range(1, count + 1)]

    def _reach(self, arguments: Arguments, now: float) -> None:
        """Carry out an order.

        Args:
            arguments: As received, the lease's token among them.
            now: Steady time, s.
        Raises:
            CommandRefused: It is no order, asks for more than the arm can do, or the e-stop is latched.
        """
        what = arguments["do"]
        if what not in _ORDERS:
            raise CommandRefused(f"an arm cannot {what!r}; use {', '.join(_ORDERS)}")
        rest = {key: value for key, value in arguments.items() if key not in ("do", TOKEN)}
        given = check_arguments(f"arm {what}", rest, *_ORDERS[what])
        if what != "stop":
            self._driver.check_free()
        self._call(lambda arm, at: _carry_out(what, given, arm, at), now)

    def _duration(self, arguments: Arguments, now: float) -> float:
        """Return the expected duration of an order, s; 0 for one that moves nothing, or is none.

        Raises:
            CommandRefused: A joint or its target is not one of this arm's.
        """
        return self._call(lambda arm, at: _duration_of(arguments, arm), now)

    commands = (CommandRow(keys.REACH, {"do": str}, _reach, name, may_take=_MAY_TAKE, duration=_duration),)


def _chain(model: ArmModel) -> dict[str, Any]:
    """Return axes and lengths, m in base_link, when all joints are at zero.

    `base` is where the arm stands; `axes` and `offsets` are of each joint, an offset from the joint before; `tip` is
    between the ends of the fingers, from the last joint, and `fingers` is along which the fingers part.
    """
    gripper = model.gripper
    ahead = np.array(gripper.offset_m) / np.linalg.norm(gripper.offset_m)
    tip = np.array(gripper.offset_m) + gripper.centre_m + ahead * np.abs(ahead @ np.array(gripper.finger_m)) / 2.0
    return {
        "base": list(model.base_m),
        "axes": [list(joint.axis) for joint in model.joints],
        "offsets": [list(joint.offset_m) for joint in model.joints],
        "tip": [round(each, 6) for each in tip.tolist()],
        "fingers": list(gripper.axis),
    }


def _carry_out(what: str, given: Arguments, arm: ArmCommands, now: float) -> None:
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


def _duration_of(arguments: Arguments, arm: ArmCommands) -> float:
    if not arm.limits:
        return 0.0  # the arm is not known yet, and refuses the order
    match arguments:
        case {"do": "move", "joints": joints}:
            speed = arguments.get("speed")
            return arm.duration(_targets(joints, arm.limits), None if speed is None else _speed(speed, arm.limits))
        case {"do": "home" | "park"} | {"do": "power", "on": False}:
            return arm.duration(None, None)
    return 0.0


def _targets(joints: Mapping[str, Any], limits: Sequence[JointLimits]) -> dict[int, float]:
    if not joints:
        raise CommandRefused('arm move needs joints, such as {"1": 0.5}')
    return dict(_target(name, place, limits) for name, place in joints.items())


def _target(name: str, place: Any, limits: Sequence[JointLimits]) -> tuple[int, float]:
    number = int(name) if name.isascii() and name.isdecimal() and len(name) <= _MOST_DIGITS else 0
    if not 1 <= number <= len(limits):
        raise CommandRefused(f"the arm has no joint {quoted(name)}; its joints are 1 to {len(limits)}")
    one = limits[number - 1]
    if isinstance(place, bool) or not isinstance(place, int | float) or not isfinite(place):
        raise CommandRefused(f"joint {number} needs a number, {one.unit}, not {quoted(place)}")
    if not one.lower - _TOLERANCE <= place <= one.upper + _TOLERANCE:
        raise CommandRefused(
            f"joint {number} goes from {one.lower:.4g} to {one.upper:.4g} {one.unit}, and not to {place:.4g}"
        )
    return number - 1, min(max(float(place), one.lower), one.upper)


def _speed(speed: float, limits: Sequence[JointLimits]) -> float:
    turning = [each for each in limits if not each.slides]
    slowest, fastest = max(each.slowest for each in turning), min(each.fastest for each in turning)
    if not slowest <= speed <= fastest + _TOLERANCE:
        raise CommandRefused(f"the joints turn at {slowest:.3g} to {fastest:.4g} rad/s, and not at {speed:.4g}")
    return min(speed, fastest)


ADAPTERS = (ArmAdapter,)

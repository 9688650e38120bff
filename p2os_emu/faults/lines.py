"""Faults of cables and ports: the robot's, and those of accessories that have one of their own."""

from collections.abc import Callable, Mapping, Sequence

from p2os_emu.emulator import EmulatedRobot
from p2os_emu.faults.kind import Arguments, FaultKind, FaultParameter, number
from p2os_emu.links.line import EmulatedLine

_ROBOTS = "robot"
_MOST_NOISE = 0.5  # of the bits: more of it would only be less
_LOST_MEANWHILE = "the cable carries bytes again; what was sent meanwhile is lost"


def _cable(text: str, robot: EmulatedRobot) -> str:
    known = _lines(robot)
    if text not in known:
        raise ValueError(f"{robot.name} has {', '.join(known)}")
    return text


def _toward(text: str, robot: EmulatedRobot) -> str:
    if text not in ("robot", "host"):
        raise ValueError("choose robot, host")
    return text


def _lines(robot: EmulatedRobot) -> Mapping[str, EmulatedLine]:
    return {_ROBOTS: robot.line, **{part: cable.line for part, cable in robot.cables.items()}}


def _on_each_line(
    treat: Callable[[EmulatedLine, Sequence[Arguments]], None],
) -> Callable[[EmulatedRobot, Sequence[Arguments]], None]:
    """Return an `apply` that calls a function with each line of a robot and the active faults there."""

    def apply(robot: EmulatedRobot, active: Sequence[Arguments]) -> None:
        for name, line in _lines(robot).items():
            treat(line, [each for each in active if each["cable"] == name])

    return apply


def _cut(line: EmulatedLine, active: Sequence[Arguments]) -> None:
    line.is_cut = bool(active)


def _freeze(line: EmulatedLine, active: Sequence[Arguments]) -> None:
    _impair(line, "frozen", bool(active))


def _garble(line: EmulatedLine, active: Sequence[Arguments]) -> None:
    _impair(line, "garbled", bool(active))


def _silence(line: EmulatedLine, active: Sequence[Arguments]) -> None:
    lost = {each["toward"] for each in active}
    if lost:
        line.impair("half-duplex", toward="both" if len(lost) > 1 else lost.pop())
    else:
        line.mend("half-duplex")


def _disturb(line: EmulatedLine, active: Sequence[Arguments]) -> None:
    if active:
        line.impair("noisy", rate=max(each["rate"] for each in active))
    else:
        line.mend("noisy")


def _impair(line: EmulatedLine, name: str, is_wanted: bool) -> None:
    if is_wanted:
        line.impair(name)
    else:
        line.mend(name)


def _pull_port(line: EmulatedLine, active: Sequence[Arguments]) -> None:
    if active:
        line.link.unplug()
    else:
        line.link.plug_in()


_CABLE = {"cable": FaultParameter("whose line: robot, or an accessory's such as laser or arm", _cable, _ROBOTS)}
_TOWARD = {"toward": FaultParameter("the end that hears nothing, robot or host", _toward, "robot")}
_RATE = {"rate": FaultParameter("of bits that arrive wrong", number(_MOST_NOISE), "0.001")}

KINDS = (
    FaultKind(
        "line-cut",
        "the cable delivers nothing, either way",
        _LOST_MEANWHILE,
        _on_each_line(_cut),
        _CABLE,
    ),
    FaultKind(
        "line-frozen",
        "the cable holds back every byte, either way, as an adapter that hangs",
        "everything that was held back arrives at once",
        _on_each_line(_freeze),
        _CABLE,
    ),
    FaultKind(
        "line-noisy",
        "some bits arrive wrong, either way",
        "all bits arrive as they were sent",
        _on_each_line(_disturb),
        {**_RATE, **_CABLE},
    ),
    FaultKind(
        "line-garbled",
        "every byte arrives as another one, either way, as at the wrong rate",
        "bytes arrive as they were sent; what came meanwhile was noise",
        _on_each_line(_garble),
        _CABLE,
    ),
    FaultKind(
        "line-half-duplex",
        "a wire is broken: one end of the cable hears nothing, the other hears all",
        _LOST_MEANWHILE,
        _on_each_line(_silence),
        {**_TOWARD, **_CABLE},
    ),
    FaultKind(
        "hang-up",
        "the port vanishes, as an adapter pulled out of its socket",
        "the port returns, at once unless a duration is given",
        _on_each_line(_pull_port),
        _CABLE,
        is_momentary=True,
    ),
)

"""Accessories of a robot, and parts of its model that it lacks: `--fit gripper,laser,ptz:vcc4,no-rear-sonar`."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace

from p2os import RobotModel
from p2os_emu.camera.image_format import read_format
from p2os_emu.hints import nearest

_NOT = "no-"


class FitError(ValueError):
    """A part does not exist or does not fit this robot; the message says what to write."""


@dataclass(frozen=True, slots=True)
class _FittedPart:
    """One accessory.

    variants: what `part:VARIANT` may say; the first one is meant when nothing is said. Empty where there is one kind.
    cabled: the variants that have a serial port of their own beside the robot's.
    least_kg: by variant, what a robot weighs at least that can carry it; none where every robot can.
    check: takes any other variant as well, and raises ValueError for what is none.
    """

    name: str
    meaning: str
    variants: tuple[str, ...] = ()
    cabled: tuple[str, ...] = ()
    least_kg: Mapping[str, float] = field(default_factory=dict)
    check: Callable[[str], object] | None = None


_PIONEER_KG, _POWERBOT_KG = 9.0, 100.0
"""What the lightest robots weigh onto which the makers built arms, heads and lasers, and the heavy arm."""

PARTS: Mapping[str, _FittedPart] = {
    part.name: part
    for part in (
        _FittedPart(
            "gripper",
            "paddles with break-beams and contacts, on a lift",
            ("pioneer", "peoplebot"),
            least_kg=dict.fromkeys(("pioneer", "peoplebot"), _PIONEER_KG),
        ),
        _FittedPart(
            "laser",
            "a SICK LMS200 on a port of its own",
            ("lms200",),
            ("lms200",),
            least_kg={"lms200": _PIONEER_KG},
        ),
        _FittedPart(
            "ptz",
            "a camera head behind AUX1",
            ("vcc4", "evid30"),
            least_kg=dict.fromkeys(("vcc4", "evid30"), _PIONEER_KG),
        ),
        _FittedPart(
            "arm",
            "the Pioneer's 5-DOF arm, or the PowerBot's 7-DOF arm of PowerCube modules on a port of its own",
            ("pioneer", "powercube"),
            ("powercube",),
            least_kg={"pioneer": _PIONEER_KG, "powercube": _POWERBOT_KG},
        ),
        _FittedPart(
            "camera",
            "a camera whose pictures an IP camera serves, in any WIDTHxHEIGHT@RATE",
            ("320x240@10", "160x120@10"),
            check=read_format,
        ),
        _FittedPart("gyro", "a gyro, read by packets or by the controller itself", ("analog", "controller")),
        _FittedPart("compass", "a TCM2 compass", ("tcm2",)),
        _FittedPart("joystick", "a joystick in the robot's socket"),
        _FittedPart("target", "three coloured rectangles at the back, by which a following robot finds its pose"),
        _FittedPart("ledge", "infrared sensors that look for edges of the floor, far and near"),
    )
}


@dataclass(frozen=True, slots=True)
class Fit:
    """The parts fitted to one robot: name to variant, which is empty where there is one kind."""

    parts: Mapping[str, str] = field(default_factory=dict)

    def has(self, part: str, variant: str | None = None) -> bool:
        """Whether a part is fitted, in a variant if one is named."""
        return part in self.parts and variant in (None, self.parts[part])

    @property
    def cables(self) -> tuple[str, ...]:
        """The parts fitted that have a serial port of their own."""
        return tuple(name for name, variant in self.parts.items() if variant in PARTS[name].cabled)


BARE = Fit()
"""Nothing beyond the model."""


def read_fit(texts: Iterable[str], model: RobotModel) -> tuple[RobotModel, Fit]:
    """Parse the parts of `--fit`.

    Args:
        texts: Parts as they are written: `gripper`, `ptz:vcc4`, `no-rear-sonar`; later ones win.
        model: What the robot is by itself.
    Returns:
        The model without what was taken off, and what is fitted.
    Raises:
        FitError: There is no such part or variant, or it does not go onto this robot.
    """
    parts: dict[str, str] = {}
    for text in texts:
        name, colon, variant = text.partition(":")
        if name.startswith(_NOT) and not colon:
            model = _without(name.removeprefix(_NOT), model, parts)
        elif name not in PARTS:
            raise FitError(
                f"there is no part {name!r}; {nearest(name, [*PARTS, *(_NOT + each for each in REMOVABLE)])}"
            )
        else:
            parts[name] = _variant(PARTS[name], variant if colon else model.parts.get(name, ""))
    for name, variant in parts.items():
        _check_load(PARTS[name], variant, model)
    return model, Fit(parts)


def _variant(part: _FittedPart, variant: str) -> str:
    if variant and part.check is not None:
        try:
            part.check(variant)
        except ValueError as error:
            raise FitError(f"{part.name}: {error}") from error
    elif variant and variant not in part.variants:
        known = f"there are {', '.join(part.variants)}" if part.variants else "there is one kind"
        raise FitError(f"there is no {part.name} {variant!r}; {known}")
    return variant or next(iter(part.variants), "")


def _check_load(part: _FittedPart, variant: str, model: RobotModel) -> None:
    least = part.least_kg.get(variant, 0.0)
    if model.mass < least:
        raise FitError(
            f"a {model.name} of {model.mass:g} kg cannot carry {part.name}:{variant}; "
            f"fit it to a robot of {least:g} kg or more"
        )


def _without(name: str, model: RobotModel, parts: dict[str, str]) -> RobotModel:
    if name in REMOVABLE:
        return REMOVABLE[name](model)
    if name not in PARTS:
        raise FitError(f"{_NOT}{name} takes nothing off; {nearest(name, [*PARTS, *REMOVABLE])}")
    parts.pop(name, None)
    return model


def _without_sonar(keep: Callable[[float], bool]) -> Callable[[RobotModel], RobotModel]:
    """Discs stay whose array sits where `keep` wants it: it is given the mean x of the array's discs, m."""

    def take_off(model: RobotModel) -> RobotModel:
        depths: dict[int, list[float]] = {}
        for disc in model.sonar:
            depths.setdefault(disc.array, []).append(disc.x)
        kept = {array for array, xs in depths.items() if keep(sum(xs) / len(xs))}
        return replace(model, sonar=tuple(disc for disc in model.sonar if disc.array in kept))

    return take_off


REMOVABLE: Mapping[str, Callable[[RobotModel], RobotModel]] = {
    "sonar": lambda model: replace(model, sonar=()),
    "front-sonar": _without_sonar(lambda depth: depth < 0.0),
    "rear-sonar": _without_sonar(lambda depth: depth >= 0.0),
    "bumpers": lambda model: replace(model, front_bumpers=0, rear_bumpers=0),
    "front-bumpers": lambda model: replace(model, front_bumpers=0),
    "rear-bumpers": lambda model: replace(model, rear_bumpers=0),
}
"""What can be taken off a model, after `no-`."""

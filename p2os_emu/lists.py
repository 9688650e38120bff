"""What the `--list-...` options print: a name, then what it is."""

from collections.abc import Callable, Iterator, Mapping

import configs
from configs.team_file import TeamFile
from p2os import RobotModel
from p2os_emu.faults.board import FAULTS
from p2os_emu.fit import PARTS, REMOVABLE
from p2os_emu.links.line import LinkProfile

Row = tuple[str, str]


def listing(kind: str) -> str:
    """A table of everything of one kind: "robots", "parts", "teams", "worlds", "links" or "faults".

    Raises:
        ConfigError: A file has an error.
    """
    rows = list(_LISTS[kind]())
    width = max(len(name) for name, _ in rows)
    return "\n".join(f"{name:{width}}  {meaning}".rstrip() for name, meaning in rows)


def _robots() -> Iterator[Row]:
    models = {name: configs.load(RobotModel, "robots", name) for name in configs.names("robots")}
    width = max(len(model.full_name) for model in models.values())
    for name, model in models.items():
        bumpers = model.front_bumpers + model.rear_bumpers
        size = f"{model.length:.2f} x {model.width:.2f} m, {model.max_velocity:.1f} m/s"
        sensors = f"{len(model.sonar)} sonar discs, {bumpers or 'no'} bumper segments"
        yield name, f"{model.full_name:{width}}  {model.firmware.value:6}  {size}, {sensors}"


def _parts() -> Iterator[Row]:
    for part in PARTS.values():
        yield part.name, part.meaning
        for variant in part.variants:
            yield f"{part.name}:{variant}", "  as it is usually" if variant == part.variants[0] else ""
    for name in REMOVABLE:
        yield f"no-{name}", f"takes the {name.replace('-', ' ')} off"


def _teams() -> Iterator[Row]:
    for name in configs.names("teams"):
        team = configs.load(TeamFile, "teams", name)
        yield name, f"{team.about}: {', '.join(robot.name for robot in team.robots)}"


def _worlds() -> Iterator[Row]:
    from p2os_emu.world.floors.families import FAMILIES  # worlds need an extra, and the other lists do not

    for name in configs.names("worlds"):
        path = configs.find("worlds", name)
        about = configs.read(path).get("about", "") if path.suffix == ".toml" else "ARIA map"
        yield name, str(about)
    for name, family in FAMILIES.items():
        yield f"{name}:SEED", f"{family.about}, generated from a whole number"


def _links() -> Iterator[Row]:
    for name in configs.names("links"):
        yield name, configs.load(LinkProfile, "links", name).summary


def _faults() -> Iterator[Row]:
    for kind in FAULTS.values():
        yield kind.name, kind.meaning
        yield "", f"  ends: {kind.ending}"
        if kind.needs:
            yield "", f"  needs: {kind.needs.name}"
        for key, parameter in kind.parameters.items():
            default = f" ({parameter.default})" if parameter.default else ""
            yield "", f"  {key}=: {parameter.meaning}{default}"
    yield "every fault", "robot=NAME: the robot that has the fault; every robot that can have it if not given"
    yield "", "@START+DURATION says when it begins and how long it lasts, in s"


_LISTS: Mapping[str, Callable[[], Iterator[Row]]] = {
    "robots": _robots,
    "parts": _parts,
    "teams": _teams,
    "worlds": _worlds,
    "links": _links,
    "faults": _faults,
}

"""Loading of worlds by name or file."""

from pathlib import Path

import configs
from geometry import MapError, read_map
from p2os_emu.world.aria_map import MOST_WALLS, world_of
from p2os_emu.world.errors import WorldError
from p2os_emu.world.floor_plan import PREFIX, floor_plan
from p2os_emu.world.spec import WorldSpec
from p2os_emu.world.world_file import WorldFile


def load_world(name: str | Path) -> WorldSpec:
    """Load a world.

    Args:
        name: Of a world in `configs/worlds` ("office"), the path of a `.toml` or `.map` file, or "plan:7" for a floor
            plan made up by the seed 7.
    Raises:
        WorldError: there is no such world, or its file has an error; says which file, where and why.
    """
    if str(name).startswith(PREFIX):
        return floor_plan(_seed(str(name).removeprefix(PREFIX)))
    try:
        path = configs.find("worlds", str(name))
        if path.suffix == ".map":
            return world_of(read_map(path), path.stem)
        file = configs.build(WorldFile, configs.read(path), str(path))
    except (configs.ConfigError, MapError) as err:
        raise WorldError(str(err)) from err
    spec = file.to_spec(path.stem, str(path))
    if (count := len(spec.walls) + len(spec.furniture)) > MOST_WALLS:
        raise WorldError(f"{path}: {count} walls and pieces of furniture are too many; use at most {MOST_WALLS}")
    return spec


def _seed(text: str) -> int:
    try:
        return int(text)
    except ValueError:
        raise WorldError(f"{PREFIX}{text} is no floor plan: write a whole number, as in {PREFIX}7") from None

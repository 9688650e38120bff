"""Loading of worlds by name or file."""

from pathlib import Path

import configs
from geometry import MapError, read_map
from p2os_emu.world.aria_map import MOST_WALLS, world_of
from p2os_emu.world.errors import WorldError
from p2os_emu.world.spec import WorldSpec
from p2os_emu.world.world_file import WorldFile


def load_world(name: str | Path) -> WorldSpec:
    """Load a world.

    Args:
        name: Of a world in `configs/worlds` ("office"), the path of a `.toml` or `.map` file, or of a floor made up by
            a seed: "plan:7", "hall:7" and the other families in `p2os_emu.world.floors.families`.
    Raises:
        WorldError: there is no such world, or its file has an error; says which file, where and why.
    """
    if ":" in str(name):
        # Here and not at the top: they are eleven modules, and most worlds are files.
        from p2os_emu.world.floors.families import floor

        if (made_up := floor(str(name))) is not None:
            return made_up
    try:
        path = _find(str(name))
        if path.suffix == ".map":
            return world_of(read_map(path), path.stem)
        file = configs.build(WorldFile, configs.read(path), str(path))
    except (configs.ConfigError, MapError) as err:
        raise WorldError(str(err)) from err
    spec = file.to_spec(path.stem, str(path))
    if (count := len(spec.walls) + len(spec.furniture)) > MOST_WALLS:
        raise WorldError(f"{path}: {count} walls and pieces of furniture are too many; use at most {MOST_WALLS}")
    return spec


def _find(name: str) -> Path:
    """Return the file of a world.

    Raises:
        ConfigError: There is none.
        WorldError: The name is that of a family of floors.
    """
    try:
        return configs.find("worlds", name)
    except configs.ConfigError:
        from p2os_emu.world.floors.families import FAMILIES

        if name in FAMILIES:
            raise WorldError(f"{name} is a family of floors: write a whole number behind it, as in {name}:7") from None
        raise

"""The target that robots carry at their backs, as data: for the emulator, which draws it, and for the vision that looks
for it.
"""

from dataclasses import dataclass
from functools import cache

from configs.loader import load

PART = "target"
"""Name of its file in `accessories`, and in `--fit`."""
Rgb = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class TargetFile:
    """Three upright rectangles: two flanks, and a centre that is nearer to the viewer. Lengths in m.

    width_m, height_m: of each rectangle. span_m: from the middle of one flank to that of the other. depth_m: by how
    much the centre is nearer. left, centre, right: colours as a viewer behind the robot sees them, 0 to 1.
    middle_m: height of their middles above the floor. inset_m: of the flanks, ahead of the rear end of the hull.
    """

    width_m: float
    height_m: float
    span_m: float
    depth_m: float
    left: Rgb
    centre: Rgb
    right: Rgb
    middle_m: float
    inset_m: float


@cache
def target_file() -> TargetFile:
    """Return the target of `configs/accessories/target.toml`.

    Raises:
        ConfigError: The file has an error.
    """
    return load(TargetFile, "accessories", PART)

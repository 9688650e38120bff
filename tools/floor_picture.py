"""Draw one floor of every generated family, as a plan: `python tools/floor_picture.py [SEED] [FILE]`.

By default the floors of seed 7, into `docs/pictures/floors.svg`. All have the same scale.
"""

import sys
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from acromovi.svg import STYLE, document, written
from geometry import Point
from p2os_emu.world import Block, WorldSpec, load_world
from p2os_emu.world.floors.families import FAMILIES

FILE = Path(__file__).resolve().parents[1] / "docs" / "pictures" / "floors.svg"
SEED = 7
SCALE = 13.0  # px for each m
COLUMNS = 4
GAP, HEAD = 24.0, 34.0  # px between floors, and above each
STYLES = (
    STYLE + ".wall{fill:#3d4248}.glass{fill:#4aa8e0}.thing{fill:#a98a63}.top{fill:#d9c9a8;fill-opacity:.6}"
    ".leaf{stroke:#d9730d;stroke-width:2}.place{fill:#1f6f4a}"
)
LEGEND = (
    ("wall", "walls"),
    ("glass", "glass"),
    ("thing", "furniture and legs"),
    ("top", "tops and boards above the floor"),
    ("leaf", "doors with a leaf"),
    ("place", "places"),
)


def names(seed: int) -> list[str]:
    """Return the names of the floors of all families."""
    return [f"{family}:{seed}" for family in FAMILIES]


def draw(floors: Sequence[WorldSpec], seed: int) -> str:
    """Return an SVG of the floors of all families. seed: that they were made with, for the title."""
    parts: list[str] = []
    y = width = 40.0
    for first in range(0, len(floors), COLUMNS):
        row = floors[first : first + COLUMNS]
        x = GAP
        for spec in row:
            left, _, right, top = _extent(spec)
            parts.append(f'<text class="name" x="{x:.0f}" y="{y + 14:.0f}">{written(spec.name)}</text>')
            parts.append(f'<text x="{x:.0f}" y="{y + 28:.0f}">{written(spec.about)}</text>')
            parts += _floor(spec, x - left * SCALE, y + HEAD + top * SCALE)
            x += max((right - left) * SCALE, 6.0 * len(spec.about)) + GAP
        width = max(width, x)
        y += HEAD + max(_extent(spec)[3] - _extent(spec)[1] for spec in row) * SCALE + GAP
    return document(width, y + 30.0, f"Generated floors, seed {seed}", STYLES, (*parts, *_legend(y)))


def _extent(spec: WorldSpec) -> tuple[float, float, float, float]:
    corners = [corner for wall in spec.walls for corner in wall.footprint]
    xs, ys = [x for x, _ in corners], [y for _, y in corners]
    return min(xs), min(ys), max(xs), max(ys)


def _floor(spec: WorldSpec, x: float, y: float) -> Iterator[str]:
    """A floor whose origin is at a place of the picture, px."""

    def put(point: Point) -> str:
        return f"{x + point[0] * SCALE:.1f} {y - point[1] * SCALE:.1f}"

    def filled(kind: str, blocks: Iterable[Block]) -> str:
        outlines = ("M" + "L".join(put(corner) for corner in block.footprint) + "Z" for block in blocks)
        return f'<path class="{kind}" d="{"".join(outlines)}"/>'

    yield filled("top", (block for block in spec.furniture if block.bottom > 0.0))
    yield filled("thing", (block for block in spec.furniture if block.bottom == 0.0))
    yield filled("glass", (wall for wall in spec.walls if wall.glass))
    yield filled("wall", (wall for wall in spec.walls if not wall.glass))
    for door in spec.moving_doors:
        yield f'<path class="leaf" d="M{put(door.jamb)}L{put(door.post)}"/>'
    for place in spec.places.values():
        cx, cy = put(place).split()
        yield f'<circle class="place" cx="{cx}" cy="{cy}" r="2.5"/>'


def _legend(y: float) -> Iterator[str]:
    x = GAP
    for kind, meaning in LEGEND:
        shape = f"M{x:.0f} {y + 6:.0f}h14"
        yield f'<path class="{kind}" d="{shape}{"" if kind == "leaf" else "v8h-14Z"}"/>'
        yield f'<text x="{x + 20:.0f}" y="{y + 14:.0f}">{meaning}</text>'
        x += 44.0 + 6.4 * len(meaning)


def main() -> None:
    """Draw the picture."""
    arguments = sys.argv[1:]
    try:
        seed = int(arguments[0]) if arguments else SEED
    except ValueError:
        sys.exit(f"tools/floor_picture.py: {arguments[0]!r} is no seed: give a whole number, as 7")
    picture = draw([load_world(name) for name in names(seed)], seed)
    (Path(arguments[1]) if len(arguments) > 1 else FILE).write_text(picture, encoding="utf-8")


if __name__ == "__main__":
    main()

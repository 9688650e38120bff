"""Pictures of walls and furniture, made of a colour, a pattern and a seed; the world needs no files of pictures."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from random import Random
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from p2os_emu.world.colours import COLOURS

PIXELS = 256
"""Edge of a picture that is repeated over a surface."""
EDGE = 2.0
"""Of that picture on the surface, m: a pixel is 8 mm."""
VARIANTS = 4
"""Different pictures of one pattern in one colour; more would only take memory."""
POSTER_COLOURS = ("white", "cream", "dark grey", "brown", "orange", "yellow", "teal", "black")
BRICKS = 8, 16  # in one picture: along a row, and rows
MORTAR = 0.08  # of a brick's height
BOARDS = 10
CHECKS = 14

Floats = NDArray[np.float64]


class Pattern(Enum):
    """Looks of a surface. All vary in brightness by a fifth and more, at several sizes, so that motion can be seen."""

    PLASTER = "plaster"
    BRICKS = "bricks"
    POSTERS = "posters"
    WOOD = "wood"
    CLOTH = "cloth"


@dataclass(frozen=True, slots=True)
class Textures:
    """How a world file describes its surfaces: each wall and each piece of furniture has one pattern of its list, by
    the seed. They are plain where the list is empty.
    """

    walls: tuple[Pattern, ...] = ()
    furniture: tuple[Pattern, ...] = ()


class SurfaceTexture(NamedTuple):
    """One surface. colour: of `COLOURS`. variant: from 0. shift: of the picture along the surface, m."""

    pattern: Pattern
    colour: str
    variant: int
    shift: float


def choose_texture(patterns: Sequence[Pattern], colour: str, seed: str) -> SurfaceTexture | None:
    """Return the texture of one surface, the same for the same seed; None where there are no patterns."""
    if not patterns:
        return None
    random = Random(seed)
    return SurfaceTexture(random.choice(patterns), colour, random.randrange(VARIANTS), random.uniform(0.0, EDGE))


def paint(texture: SurfaceTexture) -> NDArray[np.uint8]:
    """Return the picture of a texture, from above where it lies: rows of pixels with red, green, blue.

    Its opposite edges fit each other.
    """
    rng = np.random.default_rng([texture.variant, *texture.pattern.value.encode()])
    base = np.array(COLOURS[texture.colour][:3])
    match texture.pattern:
        case Pattern.PLASTER:
            painted = base * _grain(rng, 0.16)
        case Pattern.BRICKS:
            painted = _bricks(rng, base)
        case Pattern.POSTERS:
            painted = _posters(rng, base)
        case Pattern.WOOD:
            painted = _wood(rng, base)
        case Pattern.CLOTH:
            painted = _cloth(rng, base)
    result: NDArray[np.uint8] = np.round(np.clip(painted, 0.02, 1.0) * 255).astype(np.uint8)
    return result


def noise(rng: np.random.Generator, pixels: int, rows: int, columns: int) -> Floats:
    """Return smooth noise of standard deviation 1 that repeats: random values on a lattice, interpolated.

    Args:
        rng: Where it comes from.
        pixels: Edge of the result, shape (pixels, pixels).
        rows, columns: Of the lattice.
    """
    lattice = rng.normal(size=(rows, columns))
    for axis, count in ((0, rows), (1, columns)):
        at = np.arange(pixels) * count / pixels
        low = at.astype(int)
        part = (1.0 - np.cos(np.pi * (at - low))) / 2.0
        shape = (-1, 1) if axis == 0 else (1, -1)
        lattice = np.take(lattice, low, axis) * (1.0 - part.reshape(shape)) + np.take(
            lattice, (low + 1) % count, axis
        ) * part.reshape(shape)
    result: Floats = lattice / lattice.std()
    return result


def _grain(rng: np.random.Generator, strength: float) -> Floats:
    """Spots of several sizes, from 25 cm down to 3 cm, as a factor of brightness; shape (PIXELS, PIXELS, 1)."""
    spots = np.sum([noise(rng, PIXELS, cells, cells) for cells in (8, 24, 64)], axis=0)
    grain: Floats = 1.0 + strength * (spots / np.sqrt(3.0))[:, :, np.newaxis]
    return grain


def _bricks(rng: np.random.Generator, base: Floats) -> Floats:
    across, rows = BRICKS
    y, x = np.mgrid[:PIXELS, :PIXELS] / PIXELS
    row = np.floor(y * rows).astype(int)
    along = (x * across + 0.5 * (row % 2)) % across
    is_mortar = ((y * rows) % 1 < MORTAR * 2) | (along % 1 < MORTAR)
    tones = rng.normal(0.8, 0.16, (rows, across))[row, along.astype(int)]
    bricks = tones[:, :, np.newaxis] * (base * np.array([0.86, 0.62, 0.52])) * _grain(rng, 0.08)
    wall: Floats = np.where(is_mortar[:, :, np.newaxis], base * 0.9, bricks)
    return wall


def _posters(rng: np.random.Generator, base: Floats) -> Floats:
    """Sheets with blocks of text and pictures, as on a notice board."""
    wall = np.broadcast_to(base * _grain(rng, 0.07), (PIXELS, PIXELS, 3)).copy()
    for _ in range(14):
        high, wide = rng.integers(24, 72, 2)
        top, left = rng.integers(0, PIXELS - high), rng.integers(0, PIXELS - wide)
        sheet = wall[top : top + high, left : left + wide]
        sheet[:] = _colour(rng)
        for _ in range(rng.integers(3, 8)):
            tall, long = rng.integers(3, max(4, high // 3)), rng.integers(4, wide)
            y, x = rng.integers(0, high - tall), rng.integers(0, max(1, wide - long))
            sheet[y : y + tall, x : x + long] = _colour(rng)
    return wall


def _colour(rng: np.random.Generator) -> Floats:
    name = POSTER_COLOURS[rng.integers(len(POSTER_COLOURS))]
    result: Floats = np.array(COLOURS[name][:3]) * rng.uniform(0.75, 1.0)
    return result


def _wood(rng: np.random.Generator, base: Floats) -> Floats:
    """Boards that stand side by side, with grain along them."""
    x = np.arange(PIXELS) * BOARDS / PIXELS
    tones = rng.normal(0.88, 0.12, BOARDS)[x.astype(int)] * np.where(x % 1 < 0.08, 0.55, 1.0)
    grain = 1.0 + 0.10 * noise(rng, PIXELS, 8, 128) + 0.08 * noise(rng, PIXELS, 12, 32)
    boards: Floats = base * (tones * grain)[:, :, np.newaxis]
    return boards


def _cloth(rng: np.random.Generator, base: Floats) -> Floats:
    """Checks of two strengths, one over the other."""
    stripes = rng.uniform(0.45, 1.1, (2, CHECKS))
    at = np.arange(PIXELS) * CHECKS // PIXELS
    checks = (stripes[0][at][:, np.newaxis] + stripes[1][at][np.newaxis, :]) / 2.0
    cloth: Floats = base * checks[:, :, np.newaxis] * _grain(rng, 0.10)
    return cloth

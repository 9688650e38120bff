"""Pictures of floors, made of two colours and a pattern."""

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from p2os_emu.world.colours import COLOURS, check_colour
from p2os_emu.world.textures import noise

PIXELS = 512
"""Edge of the picture that is repeated over the floor."""
PERIOD = 8
"""Edge of that picture in pattern lengths: a common multiple of the periods of all patterns, 1, 2, 4 and 8."""
JOINT = 0.08
"""Width of what separates tiles and planks, in pattern lengths."""
PLANK_LENGTH, PLANK_SHIFT = 4.0, 1.5
"""Of a plank, and against the one beside it, in widths."""


class Texture(Enum):
    """Patterns."""

    PLAIN = "plain"
    CHECKER = "checker"
    TILES = "tiles"
    PLANKS = "planks"
    CARPET = "carpet"


@dataclass(frozen=True, slots=True)
class Floor:
    """How a world file describes its floor: two of `COLOURS`, and the pattern's length."""

    texture: Texture = Texture.CHECKER
    colour: str = "light grey"
    second_colour: str = "grey"
    pattern_m: float = 0.5

    def check(self) -> None:
        """See that it makes sense.

        Raises:
            ValueError: A colour is unknown, or the pattern has no length.
        """
        check_colour(self.colour)
        check_colour(self.second_colour)
        if not self.pattern_m > 0.0:
            raise ValueError("pattern_m must be above 0 m")


def picture(floor: Floor) -> NDArray[np.uint8]:
    """A square of `PERIOD` pattern lengths of the floor, from above: rows of pixels with red, green, blue."""
    across = (np.arange(PIXELS) + 0.5) * PERIOD / PIXELS
    x, y = across[np.newaxis, :], across[:, np.newaxis]
    match floor.texture:
        case Texture.CHECKER:
            is_second = np.floor(x) % 2 != np.floor(y) % 2
        case Texture.TILES:
            is_second = (x % 1 < JOINT) | (y % 1 < JOINT)
        case Texture.PLANKS:
            is_second = (y % 1 < JOINT) | ((x + PLANK_SHIFT * np.floor(y)) % PLANK_LENGTH < JOINT)
        case Texture.PLAIN | Texture.CARPET:
            is_second = np.zeros((PIXELS, PIXELS), bool)
    colours = [COLOURS[name][:3] for name in (floor.colour, floor.second_colour)]
    if floor.texture is Texture.CARPET:
        return _carpet(np.array(colours))
    palette = np.round(np.array(colours) * 255).astype(np.uint8)
    painted: NDArray[np.uint8] = palette[is_second.astype(np.uint8)]
    return painted


def _carpet(colours: NDArray[np.float64]) -> NDArray[np.uint8]:
    """Spots of several sizes, from half a pattern length to a sixteenth, between two colours."""
    rng = np.random.default_rng(0)
    spots = sum(noise(rng, PIXELS, cells, cells) for cells in (2 * PERIOD, 6 * PERIOD, 16 * PERIOD))
    share = np.clip(0.5 + spots / 5.0, 0.0, 1.0)[:, :, np.newaxis]
    mixed: NDArray[np.uint8] = np.round((colours[0] * (1.0 - share) + colours[1] * share) * 255).astype(np.uint8)
    return mixed

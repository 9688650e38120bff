"""Colour tracking as ACTS does it: 32 channels, each trained from regions of images, and their blobs.

A channel contains colour models. A model is an ellipse in the plane of chroma, which does not depend on the brightness
of the light, and a range of brightness. For tracking, all models become one lookup table over quantised colours (5 bits
of blue and red, 6 of green), so the time for an image does not depend on the number of channels. A colour that several
channels could have belongs to the nearest one.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field
from math import isfinite, sqrt
from typing import Self

import cv2
import numpy as np

from vision.blobs import MOST, Blob, blobs_of
from vision.image import Floats, Pixels, VisionError, colour_pixels

CHANNELS = 32
MAX_MODELS = 8
"""Colour models of one channel: regions that it was trained from."""
LIGHT = 2.5
"""Factor by which the light may become brighter or darker than in training."""

_HEADER = "colour-table 1"
_CELLS = 1 << 16
_NOISE = 4.0  # standard deviation of a colour value by camera, JPEG and quantisation, of 255
_REACH = 3.0  # standard deviations of chroma that belong to a model
_DARKEST = 60.0  # sum of blue, green and red, below which chroma is noise
_BRIGHTEST = 252  # of one colour value; above it the camera may have cut it off
_FEWEST = 30  # pixels of a region
_SHARE = 0.5  # of a region that is fitted: the pixels nearest to the colour of most
_UNITY = 0.6  # share of a region that must belong to its model
_SPREAD = 0.1  # standard deviation of chroma, above which a region has no one colour
_FIELDS = ("red-green", "blue-yellow", "variance", "covariance", "variance", "darkest", "brightest")


@dataclass(frozen=True, slots=True)
class ColourModel:
    """One colour: chroma (red-green, blue-yellow), its covariance (xx, xy, yy), and a range of brightness.

    Chroma is ((r - g) / (r + g + b), (2 b - r - g) / (r + g + b)); brightness is r + g + b, 0 to 765.
    """

    chroma: tuple[float, float]
    covariance: tuple[float, float, float]
    darkest: float
    brightest: float

    @classmethod
    def trained(cls, samples: Pixels, light: float = LIGHT) -> Self:
        """Return the colour that most of some pixels have.

        Up to 40 % of them may be others: the fit begins at the median and keeps the half nearest to it, repeatedly (a
        minimum covariance determinant estimate: Rousseeuw and Van Driessen, Technometrics 41, 1999).

        Args:
            samples: Shape (n, 3).
            light: Factor by which the light may change.
        Raises:
            VisionError: They are too few, too dark or over-exposed, or have no common colour.
        """
        if len(samples) < _FEWEST:
            raise VisionError(f"the region has {len(samples)} pixels; choose one of at least {_FEWEST}")
        values = samples.astype(np.float64)
        total = values.sum(axis=1)
        if np.mean(total < _DARKEST) > 1.0 - _UNITY:
            raise VisionError("the region is too dark to have a colour; use more light or a longer exposure")
        if np.mean(samples.min(axis=1) >= _BRIGHTEST) > 1.0 - _UNITY:
            raise VisionError("the region is over-exposed, so its colour is lost; use less light or a shorter exposure")
        usable = total >= _DARKEST
        chroma, total = _chroma(values[usable]), total[usable]
        model = cls._fitted(chroma, total, light)
        if (
            sqrt(max(model.covariance[0], model.covariance[2])) > _SPREAD
            or np.isfinite(model.distances(chroma, total)).mean() < _UNITY
        ):
            raise VisionError("the region has several colours; choose one inside a single coloured area")
        return model

    @classmethod
    def _fitted(cls, chroma: Floats, total: Floats, light: float) -> Self:
        centre = np.asarray(np.median(chroma, axis=0))
        spread = 1.4826 * np.median(np.abs(chroma - centre), axis=0) + 1e-3
        distance = (((chroma - centre) / spread) ** 2).sum(axis=1)
        keep = int(len(chroma) * _SHARE)
        nearest = np.arange(len(chroma))
        for _ in range(5):
            nearest = np.argpartition(distance, keep - 1)[:keep]
            centre = np.asarray(chroma[nearest].mean(axis=0))
            # The half of a normal distribution in the plane nearest to its centre has 1 - ln 2 of its variance.
            covariance = np.cov(chroma[nearest].T) / (1.0 - np.log(2.0)) + np.eye(2) * 1e-6
            off = chroma - centre
            distance = np.einsum("ni,ij,nj->n", off, np.linalg.inv(covariance), off)
        low, high = np.percentile(total[nearest], (5.0, 95.0))
        (xx, xy), (_, yy) = covariance.tolist()
        return cls((float(centre[0]), float(centre[1])), (xx, xy, yy), float(low) / light, float(high) * light)

    def distances(self, chroma: Floats, total: Floats) -> Floats:
        """Return how far colours are from the model, in squared standard deviations; infinite if not part of it.

        Chroma of dark colours is uncertain, so more of it belongs to the model. Brightness counts little: it decides
        between models of the same chroma.
        """
        noise = 2.0 * (_NOISE / np.maximum(total, 1.0)) ** 2
        xx, xy, yy = self.covariance
        wide, tall = xx + noise, yy + 3.0 * noise  # blue counts twice in the second component
        x, y = chroma[:, 0] - self.chroma[0], chroma[:, 1] - self.chroma[1]
        distance = (tall * x * x - 2.0 * xy * x * y + wide * y * y) / (wide * tall - xy * xy)
        outside = (distance > _REACH**2) | (total < self.darkest) | (total > self.brightest)
        usual = np.log(np.maximum(total, 1.0) ** 2 / max(1.0, self.darkest * self.brightest)) / 2.0
        result: Floats = np.where(outside, np.inf, distance + usual**2)
        return result


@dataclass(frozen=True, slots=True)
class _ChannelTest:
    """How well a channel finds a region and nothing else.

    hits: share of the region's pixels that belong to the channel. strays: pixels outside that do.
    largest_stray: area of the largest blob outside, px. words: the same for a person.
    """

    hits: float
    strays: int
    largest_stray: int
    words: str


@dataclass(slots=True)
class _ColourChannel:
    """A channel: its name, and colours that belong to it."""

    name: str = ""
    models: list[ColourModel] = field(default_factory=list)


class ColourTable:
    """The channels, numbered from 1 to 32, and the lookup table made of them."""

    def __init__(self) -> None:
        self.channels: dict[int, _ColourChannel] = {}
        self._table: Pixels | None = None

    def train(
        self, channel: int, pixels: Pixels, region: tuple[int, int, int, int], name: str = "", light: float = LIGHT
    ) -> ColourModel:
        """Add the colour of a region to a channel, and return it.

        Args:
            channel: 1 to 32.
            pixels: A colour image.
            region: Left, top, width and height, px.
            name: Of the channel; empty to keep the one that it has.
            light: Factor by which the light may change; 1 to 10.
        Raises:
            VisionError: There is no such channel, it is full, or the region has no colour of its own.
        """
        check_channel(channel)
        if not 1.0 <= light <= 10.0:
            raise VisionError(f"the factor of the light must be from 1 to 10, not {light:g}")
        if len(self.channels.get(channel, _ColourChannel()).models) >= MAX_MODELS:
            raise VisionError(f"channel {channel} has {MAX_MODELS} colours already; clear it first")
        model = ColourModel.trained(_cut(pixels, region).reshape(-1, 3), light)
        trained = self.channels.setdefault(channel, _ColourChannel())
        trained.models.append(model)
        trained.name = _checked_name(name) or trained.name
        self._table = None
        return model

    def clear(self, channel: int) -> None:
        """Forget what a channel was trained from."""
        check_channel(channel)
        self.channels.pop(channel, None)
        self._table = None

    def find(self, pixels: Pixels, smallest: int = 4, most: int = MOST) -> dict[int, tuple[Blob, ...]]:
        """Return the blobs of each channel that has some, the largest first.

        Args:
            pixels: A colour image.
            smallest: Area in pixels that a blob has at least.
            most: Blobs of each channel.
        """
        return blobs_of(self.classes(pixels), smallest, most)

    def classes(self, pixels: Pixels) -> Pixels:
        """Return the channel of each pixel of a colour image, shape (height, width); 0 where it has none."""
        packed = np.asarray(cv2.cvtColor(colour_pixels(pixels, "colour tracking"), cv2.COLOR_BGR2BGR565))
        return self._lookup().take(packed.view(np.uint16).reshape(pixels.shape[:2]))

    def test(self, channel: int, pixels: Pixels, region: tuple[int, int, int, int]) -> _ChannelTest:
        """Return how well a channel finds a region and nothing else in the same image."""
        check_channel(channel)
        classes = self.classes(pixels)
        inside = np.bincount(_cut(classes, region).ravel(), minlength=CHANNELS + 1) / (region[2] * region[3])
        hits, rival = float(inside[channel]), int(np.argmax(inside[1:])) + 1
        left, top, width, height = region
        classes[top : top + height, left : left + width] = 0
        strays = int(np.count_nonzero(classes == channel))
        blobs = blobs_of(classes, 1, 1).get(channel, ())
        largest = blobs[0].area if blobs else 0
        words = f"channel {channel} has {hits:.0%} of the region, and {strays} pixels outside it"
        if channel not in self.channels:
            words = f"channel {channel} is not trained"
        elif rival != channel and inside[rival] > hits:
            words += f"; channel {rival} has {inside[rival]:.0%} of it, so their colours are too much alike"
        elif hits < _UNITY:
            words += "; train it again from this region"
        elif largest > width * height / 4.0:
            words += f", {largest} of them in one place; something else has this colour"
        return _ChannelTest(hits, strays, largest, words)

    def save(self) -> bytes:
        """Return the channels as a text file, one line for each channel's name and one for each colour."""
        lines = [_HEADER, f"# {' '.join(_FIELDS)}"]
        for number, channel in sorted(self.channels.items()):
            lines.append(f"channel {number} {channel.name}".rstrip())
            for model in channel.models:
                numbers = (*model.chroma, *model.covariance, model.darkest, model.brightest)
                lines.append("colour " + " ".join(repr(number) for number in numbers))
        return ("\n".join(lines) + "\n").encode()

    @classmethod
    def load(cls, data: bytes) -> Self:
        """Return the channels that `save` wrote.

        Raises:
            VisionError: A line is wrong; the message has its number.
        """
        try:
            lines = data.decode().splitlines()
        except UnicodeDecodeError as error:
            raise VisionError(f"the file of colours is no text: byte {error.start} is not UTF-8") from None
        if not lines or lines[0].strip() != _HEADER:
            raise VisionError(f"line 1 of the file of colours must be {_HEADER!r}; train the channels anew")
        table, channel = cls(), None
        for number, line in enumerate(lines[1:], 2):
            words = line.split()
            try:
                match words:
                    case [] | ["#", *_]:
                        continue
                    case ["channel", channel_number, *name]:
                        channel = table._added(channel_number, " ".join(name))
                    case ["colour", *numbers]:
                        _add_model(channel, numbers)
                    case [other, *_]:
                        raise VisionError(f"a line begins with channel, colour or #, not with {other[:40]!r}")
            except VisionError as error:
                raise VisionError(f"line {number} of the file of colours: {error}") from None
        return table

    def _added(self, number: str, name: str) -> _ColourChannel:
        if not number.isdecimal() or len(number) > 3:
            raise VisionError(f"a channel is a number from 1 to {CHANNELS}, not {number[:40]!r}")
        check_channel(int(number))
        if int(number) in self.channels:
            raise VisionError(f"channel {int(number)} is there twice")
        return self.channels.setdefault(int(number), _ColourChannel(_checked_name(name)))

    def _lookup(self) -> Pixels:
        """Return the channel of each cell; 0 where it has none."""
        if self._table is None:
            self._table = np.zeros(_CELLS, np.uint8)
            nearest = np.full(_CELLS, np.inf)
            for number, channel in sorted(self.channels.items()):
                for model in channel.models:
                    distances = model.distances(_CELL_CHROMA, _CELL_TOTAL)
                    self._table[distances < nearest] = number
                    nearest = np.minimum(nearest, distances)
        return self._table


def _chroma(values: Floats) -> Floats:
    blue, green, red = values[:, 0], values[:, 1], values[:, 2]
    total = np.maximum(values.sum(axis=1), 1.0)
    return np.stack(((red - green) / total, (2.0 * blue - red - green) / total), axis=1)


def _cell_values() -> Floats:
    """Return blue, green and red in the middle of each cell."""
    cells = np.arange(_CELLS)
    blue, green, red = cells & 31, cells >> 5 & 63, cells >> 11
    return np.stack((blue * 8 + 3.5, green * 4 + 1.5, red * 8 + 3.5), axis=1)


_CELL_CHROMA, _CELL_TOTAL = _chroma(_cell_values()), _cell_values().sum(axis=1)


def _cut(pixels: Pixels, region: Iterable[int]) -> Pixels:
    left, top, width, height = region
    rows, columns = pixels.shape[:2]
    if width < 1 or height < 1 or left < 0 or top < 0 or left + width > columns or top + height > rows:
        raise VisionError(
            f"the region {width} x {height} px at ({left}, {top}) is not inside the image of {columns} x {rows} px"
        )
    return pixels[top : top + height, left : left + width]


def check_channel(channel: int) -> None:
    """Refuse a number that is no channel.

    Raises:
        VisionError: It is not from 1 to 32.
    """
    if isinstance(channel, bool) or not isinstance(channel, int) or not 1 <= channel <= CHANNELS:
        raise VisionError(f"a channel is a number from 1 to {CHANNELS}, not {channel!r}")


def _checked_name(name: str) -> str:
    if len(name) > 40 or not name.isprintable():
        raise VisionError("the name of a channel must be one line of at most 40 characters")
    return " ".join(name.split())


def _add_model(channel: _ColourChannel | None, numbers: list[str]) -> None:
    if channel is None:
        raise VisionError("a colour belongs to a channel; put a line such as 'channel 1' before it")
    if len(channel.models) >= MAX_MODELS:
        raise VisionError(f"a channel has at most {MAX_MODELS} colours")
    try:
        values = [float(number) for number in numbers]
    except ValueError as error:
        raise VisionError(f"a colour has {len(_FIELDS)} numbers; {str(error)[:60]}") from None
    if len(values) != len(_FIELDS) or not all(map(isfinite, values)):
        raise VisionError(f"a colour has {len(_FIELDS)} finite numbers, not {len(values)}")
    red_green, blue_yellow, xx, xy, yy, darkest, brightest = values
    if not (xx > 0.0 and yy > 0.0 and xx * yy > xy * xy and max(xx, yy) < 10.0):
        raise VisionError("the variances of a colour must be positive and belong to an ellipse")
    if not 0.0 <= darkest < brightest:
        raise VisionError("a colour's darkest value must be below its brightest")
    channel.models.append(ColourModel((red_green, blue_yellow), (xx, xy, yy), darkest, brightest))

"""Objects on the floor, kept from the sightings of many images."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import hypot, inf, tan

from apps.fetch.floor import Disc
from apps.fetch.settings import FetchSettings
from apps.fetch.sight import CameraView, ObjectSighting
from geometry import Point, Pose2D

_DRIFT = 0.003  # m, standard deviation that odometry adds between two images
_MEASURED = 10  # images after which width and height are known
_WIDEST = 0.5  # m of an obstacle; what seems wider is no object on the floor
_LEFT_FOR = 20.0  # s, in which the robot looks from elsewhere
_SETTLED = 0.2  # of a new size in the mean


@dataclass(slots=True)
class FloorObject:
    """An object: its middle in odom, m, with its variance, m^2.

    width, height: m. seen_from: m, from where it was seen last. seen: in how many images. missed: images since, in
    which it should have been. seen_at: s. is_left: why it is not to be fetched before `left_until`, s: it is there
    already, or cannot be reached. leaves: how often that was so.
    """

    colour: str
    x: float
    y: float
    variance: float
    width: float
    height: float
    seen_from: float
    seen: int
    missed: float
    seen_at: float
    is_left: str = ""
    left_until: float = inf
    leaves: int = 0

    def leave(self, reason: str, now: float, most: int) -> None:
        """Do not fetch it for some time, and not at all when it has been left `most` times."""
        self.leaves += 1
        self.is_left, self.left_until = reason, inf if self.leaves >= most else now + _LEFT_FOR

    def distance(self, x: float, y: float) -> float:
        """Return how far its middle is from a place, m."""
        return hypot(self.x - x, self.y - y)


class FloorObjects:
    """All objects that have been seen."""

    def __init__(self, settings: FetchSettings) -> None:
        self._settings = settings
        self.objects: list[FloorObject] = []

    def take(
        self,
        now: float,
        robot: Pose2D,
        sightings: Sequence[ObjectSighting],
        view: CameraView,
        *,
        earlier: Pose2D | None = None,
        covered: bool = False,
    ) -> None:
        """Take the sightings of one image.

        Args:
            now: s, when it was exposed by its stamp.
            robot: Then, in odom.
            earlier: Where the robot was when the image was exposed, if its stamp is as late as it can be; None for an
                exact stamp.
            sightings: In base_link.
            view: Of the camera.
            covered: The hand may cover parts of objects, so their sizes are not taken.
        """
        met: set[int] = set()
        for each in sorted(sightings, key=lambda each: -each.width * each.height):
            x, y = robot.transform(each.x, each.y)
            near = self._nearest(each.colour, x, y, hypot(each.x, each.y))
            if near is not None and id(near) in met:
                continue  # a part of an object that is in the image already
            if near is None:
                near = FloorObject(each.colour, x, y, 1.0, each.width, each.height, 0.0, 0, 0.0, now)
                self.objects.append(near)
            met.add(id(near))
            early_x, early_y = (earlier or robot).transform(each.x, each.y)
            self._improve(near, each, (x, y), hypot(x - early_x, y - early_y), now, covered)
        for known in self.objects:
            if id(known) not in met:
                known.missed += self._should_be_seen(known, robot, view)
        self.objects = [
            each for each in self.objects if each.missed < (self._settings.track.misses if each.seen > 2 else 2)
        ]

    def forget(self, gone: FloorObject) -> None:
        """Forget an object, and what was seen of its colour right beside it."""
        self.objects = [
            each
            for each in self.objects
            if each is not gone
            and (each.colour != gone.colour or each.distance(gone.x, gone.y) > self._settings.track.gate_m)
        ]

    def known(self) -> Iterator[FloorObject]:
        """The objects that are there for certain."""
        return (each for each in self.objects if each.seen >= self._settings.track.sightings)

    def has(self, known: FloorObject) -> bool:
        """Return whether an object is still there."""
        return any(each is known for each in self.objects)

    def to_fetch(self, now: float, colour: str, place: Point, robot: Point) -> FloorObject | None:
        """Return the object of a colour nearest to the robot that can be fetched to a place; None without one."""
        able = []
        for each in self.known():
            if each.colour != colour or (each.is_left and now < each.left_until):
                continue
            if each.distance(*place) < self._settings.object.place_m:
                each.is_left = "is at the place already"
            elif self._could_fit(each):
                able.append(each)
            elif each.seen > _MEASURED:
                each.is_left = _size_of(each)
        return min(able, key=lambda each: each.distance(*robot), default=None)

    def left(self, colour: str) -> str:
        """Return why objects of a colour are not fetched, as the end of a sentence; empty if none is left."""
        return "".join(
            f"; the one at ({round(each.x, 1) + 0.0}, {round(each.y, 1) + 0.0}) {each.is_left}"
            for each in self.known()
            if each.colour == colour and each.is_left
        )

    def discs(self, target: FloorObject | None = None) -> tuple[Disc, ...]:
        """Return all objects but one as obstacles."""
        return tuple(
            Disc(each.x, each.y, min(each.width, _WIDEST) / 2.0) for each in self.known() if each is not target
        )

    def misfit(self, each: FloorObject) -> str:
        """Return the size of an object, seen from near, that cannot be gripped, in words; empty for one that can."""
        return "" if self._has_size(each, self._settings.object.slack_m) else _size_of(each)

    def _could_fit(self, each: FloorObject) -> bool:
        """Return whether an object could be gripped, by its size as far as it is known."""
        size = self._settings.object
        slack = size.slack_m + size.slack_share * each.seen_from + 0.3 * each.width * (each.seen < _MEASURED)
        return self._has_size(each, slack)

    def _has_size(self, each: FloorObject, slack: float) -> bool:
        size = self._settings.object
        return (
            size.narrowest_m - slack <= each.width <= size.widest_m + slack
            and size.lowest_m - slack <= each.height <= size.highest_m + slack
        )

    def _nearest(self, colour: str, x: float, y: float, away: float) -> FloorObject | None:
        gate = self._settings.track.gate_m + self._settings.track.gate_share * away
        same = [each for each in self.objects if each.colour == colour]
        nearest = min(same, key=lambda each: each.distance(x, y), default=None)
        return nearest if nearest is not None and nearest.distance(x, y) <= gate else None

    def _improve(
        self, known: FloorObject, seen: ObjectSighting, place: Point, doubt: float, now: float, covered: bool
    ) -> None:
        """Take a sighting into the mean, by its variance.

        Late stamps place all images of a drive to the same side. So images that are wrong by up to `doubt`, m, move no
        object that is known better, however many they are.
        """
        track = self._settings.track
        away = hypot(seen.x, seen.y)
        before = known.variance + _DRIFT**2
        error = (track.deviation_m + track.deviation_1_m * away * away) ** 2 + doubt**2
        share = before / (before + error) if before > doubt**2 else 0.0
        known.x += share * (place[0] - known.x)
        known.y += share * (place[1] - known.y)
        known.variance = (1.0 - share) * before
        if not covered:
            part = max(share, _SETTLED) if known.seen else 1.0
            known.width += part * (seen.width - known.width)
            known.height += part * (seen.height - known.height)
            known.seen_from = away
        known.seen, known.missed, known.seen_at = known.seen + 1, 0.0, now

    def _should_be_seen(self, known: FloorObject, robot: Pose2D, view: CameraView) -> bool:
        """Return whether an object should stand wholly in the image."""
        ahead, left = robot.locate(known.x, known.y)
        away = hypot(ahead, left)
        if not view.nearest + 0.15 < away < self._settings.track.sure_m:
            return known.seen <= 2 and away > view.nearest
        return ahead > 0.0 and abs(left) < (ahead - self._settings.camera.forward_m) * 0.8 * tan(view.half_angle)


def _size_of(each: FloorObject) -> str:
    return f"is {each.width:.2f} m wide and {each.height:.2f} m high"

"""The target of three coloured rectangles, and its pose from one image.

Two flanks and a centre one that is displaced in depth are carried upright at the back of a robot. The displacement
makes the orientation visible where the target is seen straight from behind, since the centre moves between the flanks.
From about 58 degrees aside the centre hides one flank; the other one and the centre, which are not in one plane, are
enough then.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import Enum
from itertools import pairwise, product
from math import atan2, cos, exp, hypot, isfinite, radians, sin

import cv2
import numpy as np

from configs.target_file import target_file
from vision.blobs import Blob
from vision.camera_model import PinholeModel
from vision.colours import ColourTable, check_channel
from vision.image import Floats, Pixels, VisionError, colour_pixels
from vision.target_fit import TargetFit, fit, placed

_NAMES = ("left flank", "centre", "right flank")
_SMALLEST = 8  # px of a blob that may be a rectangle
_MOST = 5  # blobs of each colour that are considered
_FITS = 6  # combinations at most that are compared with the edges; that takes the longest
_YAWS = np.radians(np.arange(-80.0, 80.1, 4.0))  # of the target to the line of sight
_ROUGH = 0.2  # of the target's height in the image: error of a rough pose that may be the target
_ERROR = 0.55  # px rms of the edges of a target that is found
_TYPICAL = 0.35  # px rms of the edges at which confidence begins to drop
_SUPPORT = 0.72  # of all edges that must be where the pose has them
_EACH = 0.45  # of the edges of one rectangle
_SEEN = 0.6  # of a rectangle that must be in view
_COVERED = 0.7  # of a rectangle that must have its colour
_UNSURE = radians(8.0)  # standard deviation of the orientation above which a pose is not reported
_STEEPEST = radians(78.0)  # of the target to the line of sight
_ASIDE = radians(50.0), radians(68.0)  # of the target to the line of sight, between which its centre may hide a flank
_REST = 0.5  # of the other rectangles' area that may be left of a hidden flank
_PAIRS = 2  # combinations of two rectangles at most that are compared with the edges


@dataclass(frozen=True, slots=True)
class TargetShape:
    """Dimensions in m, and the colours. The defaults are those of `configs/accessories/target.toml`.

    width, height: of each rectangle. span: from the middle of one flank to that of the other. depth: by how much the
    centre rectangle is nearer to the viewer than the flanks; negative if it is farther. channels: of the left flank,
    the centre and the right flank, as a viewer behind the robot sees them.
    """

    width: float = field(default_factory=lambda: target_file().width_m)
    height: float = field(default_factory=lambda: target_file().height_m)
    span: float = field(default_factory=lambda: target_file().span_m)
    depth: float = field(default_factory=lambda: target_file().depth_m)
    channels: tuple[int, int, int] = (1, 2, 3)

    def __post_init__(self) -> None:
        if not all(map(isfinite, (self.width, self.height, self.span, self.depth))):
            raise VisionError("the dimensions of a target must be finite numbers, in m")
        if min(self.width, self.height) <= 0.0 or self.span < 2.0 * self.width:
            raise VisionError("width and height of a target must be positive, and its span at least twice the width")
        if abs(self.depth) < 0.02:
            raise VisionError(f"the centre must be at least 0.02 m before or behind the flanks, not {self.depth:g} m")
        for channel in self.channels:
            check_channel(channel)
        if len(set(self.channels)) != 3:
            raise VisionError(f"the three rectangles need three different channels, not {self.channels}")

    def corners(self) -> Floats:
        """Return the corners of left flank, centre and right flank, shape (3, 4, 3): upper left first, clockwise.

        Frame of the target: origin in the middle between the flanks, x away from the viewer (where the robot heads),
        y left, z up.
        """
        y, z = self.width / 2.0, self.height / 2.0
        outline = np.array([[0.0, y, z], [0.0, -y, z], [0.0, -y, -z], [0.0, y, -z]])
        half = self.span / 2.0
        middles = np.array([[0.0, half, 0.0], [-self.depth, 0.0, 0.0], [0.0, -half, 0.0]])
        corners: Floats = middles[:, None] + outline
        return corners


class TargetStatus(Enum):
    """What became of the search for a target."""

    FOUND = "found"
    NOT_SEEN = "not seen"
    PARTLY_HIDDEN = "partly hidden"
    UPSIDE_DOWN = "upside down"
    SEVERAL = "several targets"
    OTHER_OBJECTS = "colours without a target"
    UNCERTAIN = "uncertain"


@dataclass(frozen=True, slots=True)
class TargetPose:
    """Where a target is, in the levelled frame of the camera: origin in the camera, x forward, y left, z up.

    x, y, z: middle between the flanks, m. orientation: heading of the robot that carries it, rad; 0 where it is seen
    straight from behind in the middle of the image. confidence: 0 to 1.
    distance_deviation (m), bearing_deviation, orientation_deviation (rad): standard deviations.
    """

    x: float
    y: float
    z: float
    orientation: float
    confidence: float
    distance_deviation: float
    bearing_deviation: float
    orientation_deviation: float

    @property
    def distance(self) -> float:
        """Horizontal distance, m."""
        return hypot(self.x, self.y)

    @property
    def bearing(self) -> float:
        """Direction to the target, rad, left positive."""
        return atan2(self.y, self.x)


@dataclass(frozen=True, slots=True)
class TargetSighting:
    """The result of a search.

    pose: only of a target that is found. words: the result and its reason, for a person. others: poses of all targets
    where there are several.
    """

    status: TargetStatus
    words: str
    pose: TargetPose | None = None
    others: tuple[TargetPose, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class _Candidate:
    """Three blobs that may be a target, with their fit or without one, and the reason."""

    blobs: tuple[Blob, Blob, Blob]
    fitted: TargetFit | None
    reason: str
    status: TargetStatus = TargetStatus.PARTLY_HIDDEN

    @property
    def is_good(self) -> bool:
        """Whether the fit is accepted."""
        return self.status is TargetStatus.FOUND

    def quality(self) -> tuple[bool, float]:
        """Return what sorts candidates, the best first."""
        return not self.is_good, self.fitted.error if self.fitted else 0.0

    @property
    def may_be_good(self) -> bool:
        """Whether each rectangle has its colour, at least."""
        return self.is_good or self.status is TargetStatus.UNCERTAIN


class TargetFinder:
    """Finds a target of one shape in the images of one camera.

    The camera model must be of the size of the images.

    Raises:
        VisionError: The channels of the target are not trained.
    """

    def __init__(self, shape: TargetShape, table: ColourTable, camera: PinholeModel) -> None:
        for channel, name in zip(shape.channels, _NAMES, strict=True):
            if not (channel in table.channels and table.channels[channel].models):
                raise VisionError(f"channel {channel} of the target's {name} is not trained; train it from an image")
        self._shape, self._table, self._camera = shape, table, camera
        self._corners = shape.corners()

    def find(self, pixels: Pixels, tilt: float = 0.0) -> TargetSighting:
        """Return the pose of the target in an image, or why there is none.

        Args:
            pixels: A colour image of the camera.
            tilt: Of the camera, rad, up.
        Raises:
            VisionError: The image is not in colour, or not of the camera's size.
        """
        height, width = colour_pixels(pixels, "a target").shape[:2]
        if (width, height) != (self._camera.width, self._camera.height):
            raise VisionError(
                f"the image has {width} x {height} px and the camera model {self._camera.width} x "
                f"{self._camera.height}; scale the model"
            )
        found = self._table.find(pixels, _SMALLEST, _MOST)
        groups = [found.get(channel, ()) for channel in self._shape.channels]
        missing = [name for name, blobs in zip(_NAMES, groups, strict=True) if not blobs]
        if len(missing) == 3:
            return TargetSighting(TargetStatus.NOT_SEEN, "none of the target's colours is in view")
        if missing:
            words = f"{' and '.join(missing)} of the target cannot be seen: hidden, out of view, or trained wrongly"
            return self._from_aside(pixels, groups, tilt) or TargetSighting(TargetStatus.PARTLY_HIDDEN, words)
        candidates = self._candidates(pixels, groups, tilt)
        # A triple that nearly fits is no result, but the second one beside a good one.
        likely = sorted((each for each in candidates if each.may_be_good), key=_Candidate.quality)
        disjoint: list[_Candidate] = []
        for each in likely:
            if not any(set(each.blobs) & set(other.blobs) for other in disjoint):
                disjoint.append(each)
        poses = tuple(_pose(each.fitted) for each in disjoint if each.fitted)
        if len(poses) > 1 and disjoint[0].is_good:
            words = f"{len(poses)} targets are in view; it is not known which is meant"
            return TargetSighting(TargetStatus.SEVERAL, words, None, poses)
        if poses and disjoint[0].is_good:
            return TargetSighting(TargetStatus.FOUND, f"target at {poses[0].distance:.2f} m", poses[0])
        return self._from_aside(pixels, groups, tilt) or self._refused(groups, candidates, tilt)

    def _from_aside(self, pixels: Pixels, groups: Sequence[Sequence[Blob]], tilt: float) -> TargetSighting | None:
        """Return a target whose centre hides one of its flanks; None if there is none, or more than one."""
        classes: Pixels | None = None
        found = []
        for hidden in (0, 2):
            shown = [number for number in range(3) if number != hidden]
            rough = [
                (starts[0][0], blobs, starts)
                for blobs in product(*(groups[number] for number in shown))
                if max((each.area for each in groups[hidden]), default=0) < _REST * min(each.area for each in blobs)
                and (starts := self._rough(blobs, tilt, 1.0, shown))
                and abs(_aspect(starts[0][1])) > _ASIDE[0] / 2.0
            ]
            for _, _, starts in sorted(rough, key=lambda each: each[0])[:_PAIRS]:
                corners = self._corners[shown]
                fits = [each for _, start in starts if (each := fit(pixels, self._camera, corners, start, tilt))]
                fits.sort(key=lambda each: each.error / max(0.1, float(each.support.mean())))
                if fits and self._hides(fits, hidden):
                    classes = self._table.classes(pixels) if classes is None else classes
                    covered = self._covered(fits[0].pose, classes, tilt)
                    if all(covered[number] >= _COVERED for number in shown):
                        found.append(_pose(fits[0]))
        if len(found) != 1:
            return None
        return TargetSighting(TargetStatus.FOUND, f"target at {found[0].distance:.2f} m, from aside", found[0])

    def _hides(self, fits: Sequence[TargetFit], hidden: int) -> bool:
        """Return whether the best fit, without a rival, has the target so far aside that its centre hides a flank."""
        best = fits[0]
        aspect = _aspect(best.pose) * (1.0 if hidden == 2 else -1.0)
        rivals = [each for each in fits[1:] if abs(each.pose[3] - best.pose[3]) > 2.0 * _UNSURE]
        return (
            _ASIDE[0] < aspect <= _ASIDE[1]
            and float(best.seen.min()) >= _SEEN
            and float(best.support.min()) >= _EACH
            and best.error <= _ERROR
            and float(best.support.mean()) >= _SUPPORT
            and best.deviations[3] <= _UNSURE
            and not any(each.error < 1.3 * best.error + 0.05 for each in rivals)
        )

    def _refused(self, groups: Sequence[Sequence[Blob]], candidates: list[_Candidate], tilt: float) -> TargetSighting:
        if candidates and candidates[0].may_be_good:
            return TargetSighting(candidates[0].status, candidates[0].reason)
        if any(self._rough(blobs, tilt, -1.0) for blobs in product(*groups)):
            return TargetSighting(TargetStatus.UPSIDE_DOWN, "the target is upside down, or its flanks are exchanged")
        if candidates:
            return TargetSighting(candidates[0].status, candidates[0].reason)
        words = "the colours of the target are in view, but not in its arrangement: other objects, or partly hidden"
        return TargetSighting(TargetStatus.OTHER_OBJECTS, words)

    def _candidates(self, pixels: Pixels, groups: Sequence[Sequence[Blob]], tilt: float) -> list[_Candidate]:
        """Return all triples of blobs in the arrangement of the target, those that nearly are it first."""
        rough = [
            (starts[0][0], blobs, starts) for blobs in product(*groups) if (starts := self._rough(blobs, tilt, 1.0))
        ]
        if not rough:
            return []
        classes = self._table.classes(pixels)
        found = []
        for _, blobs, starts in sorted(rough, key=lambda each: each[0])[:_FITS]:
            fits = [each for _, start in starts if (each := fit(pixels, self._camera, self._corners, start, tilt))]
            found.append(self._judged(blobs, fits, classes, tilt))
        return sorted(found, key=lambda each: (not each.may_be_good, -sum(blob.area for blob in each.blobs)))

    def _judged(self, blobs: tuple[Blob, ...], fits: list[TargetFit], classes: Pixels, tilt: float) -> _Candidate:
        triple = (blobs[0], blobs[1], blobs[2])
        if not fits:
            return _Candidate(triple, None, "the edges of the target cannot be found: hidden in part, or blurred")
        fits.sort(key=lambda each: each.error / max(0.1, float(each.support.mean())))
        best = fits[0]
        aspect = _aspect(best.pose)
        covered = self._covered(best.pose, classes, tilt)
        for number, name in enumerate(_NAMES):
            if best.seen[number] < _SEEN or best.support[number] < _EACH or covered[number] < _COVERED:
                return _Candidate(triple, best, f"the {name} of the target is hidden in part or out of view")
        if best.error > _ERROR or best.support.mean() < _SUPPORT or abs(aspect) > _STEEPEST:
            return _Candidate(
                triple,
                best,
                "the edges do not agree with the target: hidden in part, or other objects",
                TargetStatus.UNCERTAIN,
            )
        rivals = [each for each in fits[1:] if abs(each.pose[3] - best.pose[3]) > 2.0 * _UNSURE]
        if best.deviations[3] > _UNSURE or any(each.error < 1.3 * best.error + 0.05 for each in rivals):
            return _Candidate(
                triple, best, "the target is too far or too small to tell its orientation", TargetStatus.UNCERTAIN
            )
        return _Candidate(triple, best, "", TargetStatus.FOUND)

    def _covered(self, pose: Floats, classes: Pixels, tilt: float) -> list[float]:
        """Return the share of each rectangle, its margin left out, that has its colour."""
        grid = np.array([(u, v) for u in np.linspace(0.25, 0.75, 5) for v in np.linspace(0.15, 0.85, 9)])
        shares = []
        wide = np.ones((3, 3), np.uint8)  # a rectangle of few pixels has no inside
        for channel, corners in zip(self._shape.channels, self._corners, strict=True):
            across, down = corners[1] - corners[0], corners[3] - corners[0]
            points = corners[0] + grid[:, :1] * across + grid[:, 1:] * down
            at = np.rint(self._camera.pixels_of(placed(points, pose, tilt)))
            inside = ((at >= 0) & (at < np.array([self._camera.width, self._camera.height]))).all(axis=1)
            columns, rows = at[inside].astype(int).T
            own = cv2.dilate((classes == channel).astype(np.uint8), wide)
            shares.append(float(own[rows, columns].sum() / len(grid)))
        return shares

    def _rough(
        self, blobs: tuple[Blob, ...], tilt: float, upright: float, shown: Sequence[int] = (0, 1, 2)
    ) -> list[tuple[float, Floats]]:
        """Return poses at which the target would look roughly like the blobs, with their errors; the best first.

        For a given orientation the position follows from a linear system, the same for all orientations but for its
        right side, so all are tried at once.

        Args:
            blobs: Left flank, centre, right flank, or those of them that are shown.
            tilt: Of the camera.
            upright: 1, or -1 to have the image turned upside down.
            shown: Numbers of the blobs' rectangles.
        """
        heights = [blob.area / blob.width for blob in blobs]
        middle = np.mean([(blob.x, blob.y) for blob in blobs], axis=0)
        is_in_order = all(upright * left.x < upright * right.x for left, right in pairwise(blobs))
        if max(heights) > 3.0 * min(heights) or not is_in_order:
            return []
        marks = [(blob.x, blob.y + part * tall) for blob, tall in zip(blobs, heights, strict=True) for part in _PARTS]
        seen = self._camera.rays_of(np.array(marks))
        level = seen @ np.array([[cos(tilt), 0.0, sin(tilt)], [0.0, 1.0, 0.0], [-sin(tilt), 0.0, cos(tilt)]])
        slopes = upright * level[:, 1:] / level[:, :1]
        points = (
            self._corners[list(shown)].mean(axis=1)[:, None]
            + np.array([[0.0, 0.0, -upright * part] for part in _PARTS]) * self._shape.height
        )
        points = points.reshape(-1, 3)
        yaws = _YAWS + atan2(float(slopes[:, 0].mean()), 1.0)
        x = np.cos(yaws) * points[:, :1] - np.sin(yaws) * points[:, 1:2]
        y = np.sin(yaws) * points[:, :1] + np.cos(yaws) * points[:, 1:2]
        ones, nought = np.ones(len(points)), np.zeros(len(points))
        system = np.concatenate(
            (np.stack((-slopes[:, 0], ones, nought), axis=1), np.stack((-slopes[:, 1], nought, ones), axis=1))
        )
        right = np.concatenate((slopes[:, :1] * x - y, slopes[:, 1:] * x - points[:, 2:]))
        positions = np.linalg.pinv(system) @ right
        off = np.sqrt(((system @ positions - right) ** 2).mean(axis=0)) / self._shape.height
        off = np.where((positions[0] > 0.15) & np.isfinite(middle).all(), off, np.inf)
        before, after = np.concatenate(([np.inf], off[:-1])), np.concatenate((off[1:], [np.inf]))
        least = np.flatnonzero((off <= before) & (off < after) & (off < max(_ROUGH, 3.0 / min(heights))))
        least = least[np.argsort(off[least])][:2]
        return [(float(off[at]), np.array([*positions[:, at], yaws[at], 0.0, 0.0])) for at in least]


_PARTS = (-0.5, 0.0, 0.5)  # of a rectangle's height: marks of a blob for the rough pose


def _aspect(pose: Floats) -> float:
    """Return the angle of a target to the line of sight, rad."""
    return float(pose[3]) - atan2(float(pose[1]), float(pose[0]))


def _pose(fitted: TargetFit) -> TargetPose:
    x, y, z, yaw = (float(value) for value in fitted.pose[:4])
    distance = hypot(x, y)
    along = hypot(x * fitted.deviations[0], y * fitted.deviations[1]) / distance
    across = hypot(y * fitted.deviations[0], x * fitted.deviations[1]) / distance
    orientation = float(fitted.deviations[3])
    confidence = float(fitted.support.mean()) * exp(-((fitted.error / _TYPICAL) ** 2) / 2.0)
    return TargetPose(x, y, z, yaw, min(1.0, confidence), along, across / distance, orientation)

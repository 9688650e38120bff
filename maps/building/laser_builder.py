"""A map made of laser scans while they come: each scan is matched with those seen near it, and loops are closed.

Scans are kept where the robot sees something new (key scans). Each is a node of a pose graph, held to the one before by
odometry and matching, to earlier ones by loops, and at the end to all that see the same walls.
"""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from geometry import Pose2D, wrap_angle
from maps.building.pose_graph import Edge, optimised, weights
from maps.building.readings import BeamView, Floats, moved
from maps.building.scan_matching import Integers, Match, SurfaceField, field_of, scan_normals

FEWEST = 30
"""Fewest echoes of a scan that is used."""
SQUARE, ROWS = 0.25, 1_000_003
"""m of the squares by which it is estimated what two key scans share; and numbers from one column to the next."""
MOST_SHARED = 6
"""Earlier key scans that each is matched with in the end, those that share most."""
BASE = -1
"""Number of the map that is extended, as the first end of an edge."""
AROUND = 12.0
"""m within which a scan is matched with the map that is extended."""
AGREES, AGREES_TURN = 0.025, 0.006
"""m and rad by which a loop may disagree without all poses being improved at once."""
LEAST_OVERLAP = 0.25
"""Share of a scan's points that must agree with those near it; else odometry alone says where it was taken."""


class NotPlaced(ValueError):
    """The first scan does not fit the map that is to be extended."""


@dataclass(frozen=True, slots=True)
class MappingSettings:
    """How a map is built.

    key_distance, key_turn: m and rad from the last key scan at which a new one is kept.
    same_distance, same_turn: m and rad from an earlier key scan within which none is kept.
    near: m within which key scans make up what a scan is matched with. most_near: how many at most.
    odometry_distance, odometry_turn: errors of odometry per m, and per rad and m: standard deviations.
    loop_after: m of driving after which a place is looked for again. loop_overlap: least share of points that agree.
    loop_window, loop_drift: m of the window in which a loop is searched: at least, and per m driven.
    start_window, start_turn: m and rad from the given start, within which the robot is searched on a map to extend.
    start_overlap: least share of the first scan that agrees with that map, which may have changed.
    match_weight: of the information of a match beside that of odometry; 1 for points as exact as those of a laser.
    """

    key_distance: float = 0.4
    key_turn: float = 0.35
    same_distance: float = 0.25
    same_turn: float = 0.2
    near: float = 5.0
    most_near: int = 14
    odometry_distance: float = 0.03
    odometry_turn: float = 0.05
    loop_after: float = 6.0
    loop_overlap: float = 0.7
    loop_window: float = 0.4
    loop_drift: float = 0.03
    start_window: float = 1.0
    start_turn: float = 0.5
    start_overlap: float = 0.5
    match_weight: float = 1.0


@dataclass(slots=True)
class KeyScan:
    """A scan that is kept: what was seen, normals, pose in `map`, and how far the robot had driven, m."""

    view: BeamView
    normals: Floats
    pose: Pose2D
    driven: float
    neighbours: dict[int, float] = field(default_factory=dict)  # number to m between the poses


class LaserMapBuilder:
    """Key scans and their poses; the first pose is the origin of the map unless another is given."""

    def __init__(
        self,
        settings: MappingSettings | None = None,
        origin: Pose2D | None = None,
        base: tuple[Floats, Floats] | None = None,
        normals_of: Callable[[Floats, Floats], Floats] = scan_normals,
    ) -> None:
        """Begin a map.

        Args:
            settings: How it is built.
            origin: Pose of the robot at the first scan, in `map`; about, where a map is extended.
            base: Points and normals of the map that is extended, as of `surface_points`.
            normals_of: Returns the normals of points and origins of a view.
        """
        self._normals_of = normals_of
        self.settings = settings or MappingSettings()
        self._base = None if base is None else SurfaceField(*base, one_sided=False)
        self.keys: list[KeyScan] = []
        self.edges: list[Edge] = []
        self.loops = 0
        self._origin = origin or Pose2D()
        self._pose = self._origin
        self._odometry: Pose2D | None = None  # with the latest scan
        self._reference = 0  # key scan that the latest pose is measured from
        self._driven = 0.0
        self._since_loop = 0.0  # m driven when a loop was last closed
        self._field: tuple[tuple[int, ...], SurfaceField] | None = None

    @property
    def pose(self) -> Pose2D:
        """Where the robot was at the latest scan, in `map`."""
        return self._pose

    @property
    def driven(self) -> float:
        """Metres driven while the map was built, by odometry."""
        return self._driven

    @property
    def correction(self) -> Pose2D:
        """Frame `odom` in `map`."""
        if self._odometry is None:
            return self._origin
        return self._pose.compose(Pose2D().relative_to(self._odometry))

    def add(self, view: BeamView) -> bool:
        """Take a scan.

        Returns:
            Whether it was kept, so that the map has changed.
        Raises:
            NotPlaced: It is the first, and does not fit the map that is to be extended.
        """
        if len(view.points) < FEWEST:
            return False
        if self._odometry is None:
            self._begin(view)
            return True
        step = view.pose.relative_to(self._odometry)
        guess = self._pose.compose(step)
        self._driven += float(np.hypot(step.x, step.y))
        reference = self.keys[self._reference].pose
        if not self._is_away(guess, reference):
            self._pose, self._odometry = guess, view.pose
            return False
        normals = self._normals_of(view.points, view.origins)
        match = self._matched(view, normals, guess)
        if match is not None and match.overlap < LEAST_OVERLAP:
            match = None
        pose = guess if match is None else self.keys[self._reference].pose.compose(match.pose)
        self._pose, self._odometry = pose, view.pose
        known = self._known(pose)
        if known is not None and match is not None and match.overlap > self.settings.loop_overlap:
            self._reference = known
            return False
        self._keep(view, normals, match)
        self._close_loops(len(self.keys) - 1)
        return True

    def refine(self, rounds: int = 1) -> None:
        """Match all key scans that see the same walls, and find the poses that agree best with all of that."""
        for _ in range(rounds if len(self.keys) > 1 else 0):
            edges = [edge for edge in self.edges if not edge.may_be_false] + self._agreements()
            edges += [edge for number in range(len(self.keys)) for edge in self._held_to_base(number)]
            self._set_poses(self._optimised(edges))

    def _begin(self, view: BeamView) -> None:
        """Take the first scan."""
        normals = self._normals_of(view.points, view.origins)
        if self._base is not None:
            settings = self.settings
            guess = self._base.correlate(view.points, self._pose, settings.start_window, settings.start_turn)
            match = self._base.align(view.points, normals, guess)
            if match is None or match.overlap < settings.start_overlap:
                share = 0.0 if match is None else match.overlap
                raise NotPlaced(
                    f"{share:.0%} of the first scan fits the map about ({self._pose.x:.2f}, {self._pose.y:.2f}); "
                    f"{settings.start_overlap:.0%} are needed: give the pose where the robot stands, in the map's frame"
                )
            self._pose = match.pose
        self._odometry = view.pose
        self._keep(view, normals, None)

    def _optimised(self, edges: list[Edge]) -> list[Pose2D]:
        """Poses of the key scans that agree best; the map that is extended does not move, or else the first one."""
        if self._base is None:
            return optimised([key.pose for key in self.keys], edges)
        shifted = [replace(edge, first=edge.first + 1, last=edge.last + 1) for edge in edges]
        return optimised([Pose2D(), *(key.pose for key in self.keys)], shifted)[1:]

    def _held_to_base(self, number: int) -> list[Edge]:
        """The edge from the map that is extended to a key scan, where they agree."""
        if self._base is None:
            return []
        key = self.keys[number]
        match = self._weighed(self._base.align(key.view.points, key.normals, key.pose, coarsest=0.1))
        if match is None or match.overlap < 0.4:
            return []
        return [Edge(BASE, number, match.pose, match.information, may_be_false=True)]

    def _is_away(self, pose: Pose2D, other: Pose2D) -> bool:
        step = pose.relative_to(other)
        settings = self.settings
        return bool(np.hypot(step.x, step.y) > settings.key_distance or abs(step.heading) > settings.key_turn)

    def _known(self, pose: Pose2D) -> int | None:
        """A key scan near which nothing new is seen, of those that the pose is known to."""
        for number in self._near(self._reference):
            moved = pose.relative_to(self.keys[number].pose)
            if (
                np.hypot(moved.x, moved.y) < self.settings.same_distance
                and abs(moved.heading) < self.settings.same_turn
            ):
                return number
        return None

    def _near(self, number: int) -> list[int]:
        """Key scans near one in the graph, so that their poses relative to it are known well."""
        reached = {number: 0.0}
        queue = deque([number])
        while queue:
            here = queue.popleft()
            for other, length in self.keys[here].neighbours.items():
                way = reached[here] + length
                if way < self.settings.near and way < reached.get(other, np.inf):
                    reached[other] = way
                    queue.append(other)
        middle = self.keys[number].pose

        def away(other: int) -> float:
            pose = self.keys[other].pose
            turn = abs(wrap_angle(pose.heading - middle.heading))
            return float(np.hypot(pose.x - middle.x, pose.y - middle.y)) + 0.5 * turn

        return sorted(reached, key=away)[: self.settings.most_near]

    def _matched(self, view: BeamView, normals: Floats, guess: Pose2D) -> Match | None:
        """The pose of a scan relative to the reference, from those near it."""
        near = tuple(self._near(self._reference))
        origin = self.keys[self._reference].pose
        if self._field is None or self._field[0] != (self._reference, *near):
            self._field = (self._reference, *near), self._field_from(origin, near)
        start = guess.relative_to(origin)
        prior = self._odometry_information(start) / self.settings.match_weight
        return self._weighed(self._field[1].align(view.points, normals, start, prior))

    def _weighed(self, match: Match | None) -> Match | None:
        """A match with the weight that matches have beside odometry."""
        return match and replace(match, information=match.information * self.settings.match_weight)

    def _field_from(self, origin: Pose2D, numbers: tuple[int, ...] | list[int]) -> SurfaceField:
        keys = [self.keys[number] for number in numbers]
        parts = [(key.pose.relative_to(origin), key.view.points, key.normals) for key in keys]
        if self._base is not None:
            near = np.hypot(*(self._base.points - (origin.x, origin.y)).T) < AROUND
            parts.append((Pose2D().relative_to(origin), self._base.points[near], self._base.normals[near]))
        return field_of(parts, one_sided=self._base is None)

    def _odometry_information(self, step: Pose2D) -> Floats:
        """How well odometry alone knows a step."""
        length = float(np.hypot(step.x, step.y))
        along = 0.01 + self.settings.odometry_distance * length
        turn = 0.01 + self.settings.odometry_turn * (abs(step.heading) + 0.5 * length)
        return np.diag([along**-2, along**-2, turn**-2])

    def _keep(self, view: BeamView, normals: Floats, match: Match | None) -> None:
        """Add a key scan, held to the reference."""
        number = len(self.keys)
        self.keys.append(KeyScan(view, normals, self._pose, self._driven))
        if number:
            step = self._pose.relative_to(self.keys[self._reference].pose)
            information = self._odometry_information(step)
            if match is not None:
                information = information + match.information
            self._join(Edge(self._reference, number, step, information))
        self.edges += self._held_to_base(number)
        self._reference = number

    def _join(self, edge: Edge) -> None:
        self.edges.append(edge)
        length = float(np.hypot(edge.pose.x, edge.pose.y))
        self.keys[edge.first].neighbours[edge.last] = length
        self.keys[edge.last].neighbours[edge.first] = length

    def _close_loops(self, number: int) -> None:
        """Look for places seen long ago about a new key scan, and move all poses where one is found."""
        found = self._loop(number)
        if found is None:
            return
        self._join(found)
        if self._agrees(found):
            self.loops += 1
            self._since_loop = self._driven
            return
        poses = self._optimised(self.edges)
        if weights(poses, [found])[0] < 0.3:  # all others disagree
            self._leave(found)
            return
        self.loops += 1
        self._since_loop = self._driven
        self._set_poses(poses)

    def _agrees(self, edge: Edge) -> bool:
        """Whether the poses are so near to what was measured that it is enough to improve them at the end."""
        step = self.keys[edge.last].pose.relative_to(self.keys[edge.first].pose).relative_to(edge.pose)
        return bool(np.hypot(step.x, step.y) < AGREES and abs(step.heading) < AGREES_TURN)

    def _leave(self, edge: Edge) -> None:
        self.edges.pop()
        del self.keys[edge.first].neighbours[edge.last]
        del self.keys[edge.last].neighbours[edge.first]

    def _loop(self, number: int) -> Edge | None:
        settings = self.settings
        key = self.keys[number]
        drift = key.driven - self._since_loop
        window = min(3.0, settings.loop_window + settings.loop_drift * drift)
        known = set(self._near(number))
        candidates = [
            (float(np.hypot(other.pose.x - key.pose.x, other.pose.y - key.pose.y)), other_number)
            for other_number, other in enumerate(self.keys[:number])
            if key.driven - other.driven > settings.loop_after and other_number not in known
        ]
        candidates = [each for each in sorted(candidates) if each[0] < window + 2.0]
        if not candidates:
            return None
        nearest = candidates[0][1]
        origin = self.keys[nearest].pose
        seen = self._field_from(origin, self._near(nearest))
        start = key.pose.relative_to(origin)
        turn = min(0.5, 0.08 + 0.01 * drift)
        guess = seen.correlate(key.view.points, start, window, turn)
        match = seen.align(key.view.points, key.normals, guess)
        if match is None or match.overlap < settings.loop_overlap or not match.is_constrained:
            return None
        return Edge(nearest, number, match.pose, match.information * settings.match_weight, may_be_false=True)

    def _agreements(self) -> list[Edge]:
        """Edges between all key scans that see the same walls, by their present poses."""
        edges = []
        positions = np.array([(key.pose.x, key.pose.y) for key in self.keys])
        fields: dict[int, SurfaceField] = {}
        cells = [self._seen_cells(number) for number in range(len(self.keys))]
        for number, key in enumerate(self.keys):
            away = np.hypot(*(positions[:number] - positions[number]).T)
            near = np.flatnonzero(away < 0.8 * self.settings.near)
            shared = sorted(((_share(cells[int(other)], cells[number]), int(other)) for other in near), reverse=True)
            shared = shared[:MOST_SHARED]
            for share, other in shared:
                if share < 0.3:
                    break
                if other not in fields:
                    fields[other] = SurfaceField(self.keys[other].view.points, self.keys[other].normals)
                start = key.pose.relative_to(self.keys[other].pose)
                match = self._weighed(fields[other].align(key.view.points, key.normals, start, coarsest=0.08))
                if match is not None and match.overlap > 0.3:
                    edges.append(Edge(other, number, match.pose, match.information, may_be_false=True))
        return edges

    def _seen_cells(self, number: int) -> Integers:
        """Squares of a coarse grid in which a key scan has echoes, as numbers."""
        key = self.keys[number]
        columns, rows = np.floor(moved(key.view.points, key.pose) / SQUARE).astype(np.int64).T
        result: Integers = np.unique(columns * ROWS + rows)
        return result

    def _set_poses(self, poses: list[Pose2D]) -> None:
        """Move all key scans, and the robot with its reference."""
        step = self._pose.relative_to(self.keys[self._reference].pose)
        for key, pose in zip(self.keys, poses, strict=True):
            key.pose = pose
        self._pose = self.keys[self._reference].pose.compose(step)
        self._field = None


def _share(cells: Integers, others: Integers) -> float:
    """Which part of what one key scan sees the other sees as well."""
    return len(np.intersect1d(cells, others, assume_unique=True)) / max(1, min(len(cells), len(others)))

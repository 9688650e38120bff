"""The occupancy grid: for each cell of the floor, the evidence of an obstacle.

A hit counts more than a ray that passes. But a few passing rays remove an obstacle, so that a person who has walked on
is forgotten at once, and a room may change. An obstacle where the floor was free before may go away again. So may one
that was seen only for a short time, because a walking person is also seen somewhere for the first time. A walking
person who leaves the view is taken to have walked on.

What sonar hears and the laser sees through, such as glass, is remembered apart: a laser ray that passes shows nothing
of it. It stays until a disc listens from a similar direction and no longer hears it, or until no way is left without
the place. From another direction a smooth surface reflects the sound elsewhere.
"""

from dataclasses import dataclass
from math import ceil

import numpy as np

from apps.indoor_navigation.algorithms.bodies import Bodies
from apps.indoor_navigation.algorithms.perception import Perceived
from apps.indoor_navigation.algorithms.planning.area import NEVER, OCCUPIED, PASSABLE, PASSED, Area
from apps.indoor_navigation.algorithms.planning.believed_rays import MAX_OFFSET, BelievedRays, seams
from apps.indoor_navigation.algorithms.planning.floor import FloorMap
from apps.indoor_navigation.algorithms.planning.lone_sonar import echoes, free_cells, may_be_people
from apps.indoor_navigation.algorithms.planning.terrain import distances
from apps.indoor_navigation.algorithms.rays import Rays
from apps.indoor_navigation.data import Floats, Ints, ObstRead, Place, Pose

HIT = 2  # evidence that a reading adds to a cell that a ray hits; it adds PASSED where a ray passes
SURELY_FREE = -3  # evidence of a cell that is not a wall, whatever stands there later
MAX_EVIDENCE, MIN_EVIDENCE = 8, -4  # so a few rays change a cell
MARGIN = 5.0  # m that the area grows beyond the need, since each growth copies it
TRACE_TIME, TRACE_SPEED = 2.0, 1.2  # s before a person moved somewhere, and m/s, within which it came there
WALKER_TIME = 0.5  # s after a person was at a place during which a hit there belongs to the person
ECHO, MAX_ECHO = 2, 6  # evidence of an echo that the laser sees through, and the most of it
BESIDE_BODY = 0.2  # m about a body within which an echo is the body's
SAME_WALL = 0.15  # m between a wall of the map and where it is seen
WRONG_SHARE = 0.15  # of walls of the map that are not there, beside those that are; above, the map does not fit
SURFACE_SHARE = 0.3  # of a new hit in the place of the surface in a cell with an obstacle; the rest is that before

Cells = tuple[Ints, Ints]
"""Rows and columns."""


@dataclass(frozen=True, slots=True)
class GridParameters:
    """Resolution in m, and what evidence counts.

    resolution: edge of a cell. reach: length up to which a laser ray is used. lone_reach: likewise, of a sonar ray,
    whose distance is more exact than its direction. largest: maximum edge of an area that is extended to a goal.
    settled: s after the first hit from which on a hit shows a wall instead of a walking person. gone: s after the last
    hit when a walking person counts as gone although the place is out of view. stands: s for which something new that
    a robot without laser hears may be a person who stands there; 0 where nobody is expected.
    """

    resolution: float
    reach: float
    lone_reach: float
    largest: float
    settled: float
    gone: float
    stands: float


class Grid:
    """The grid. `area` is replaced as a whole when it grows, so that other threads may read it meanwhile."""

    def __init__(self, parameters: GridParameters) -> None:
        self._parameters = parameters
        self._map: Area | None = None
        self.forget()

    def use_map(self, floor: FloorMap | None) -> None:
        """Begin anew with the knowledge of a map, or with none."""
        self._map = floor.area(self._parameters.resolution) if floor is not None else None
        self.forget()

    def forget(self) -> None:
        """Clear the grid; what the map shows stays."""
        nothing = Area.of(0.0, 0.0, self._parameters.resolution, np.zeros((0, 0), np.int8))
        self.area = nothing if self._map is None else self._map.copied()
        self._has_walkers = False  # whether anything has moved; most of the time nothing has

    def forget_transient(self, before: float, *, with_panes: bool = False) -> bool:
        """Clear obstacles that may have gone since they were hit, before s; return whether there were any.

        Those are all on free floor of the map. Without a map they are what has not become a wall, and `with_panes` also
        what only sonar hears.
        """
        part = self.area if self._map is None else self._mapped()
        is_old = part.hit_at < before
        if self._map is None:
            hits, echoes = is_old & ~part.fixed, is_old & with_panes
        else:
            hits = echoes = is_old & (self._map.evidence == PASSED)
        hits, echoes = hits & (part.evidence >= OCCUPIED), echoes & (part.echo >= OCCUPIED)
        part.evidence[hits], part.echo[echoes] = PASSED, 0
        part.first_hit[hits], part.fixed[hits] = NEVER, False
        return bool(hits.any() or echoes.any())

    def doubt_map(self) -> bool:
        """Forget what only the map shows, if sensors contradict much of it; return whether that was so.

        Walls of the map count that rays have passed, beside those that were seen where they should be.
        """
        if self._map is None:
            return False
        part = self._mapped()
        is_wall, is_seen = self._map.evidence >= OCCUPIED, part.hit_at > -np.inf
        off = distances(is_seen & (part.evidence >= OCCUPIED), SAME_WALL, part.resolution)
        is_right = is_wall & (off <= SAME_WALL)
        is_wrong = is_wall & ~is_right & (part.evidence <= PASSED)
        if is_wrong.sum() <= WRONG_SHARE * is_right.sum():
            return False
        unseen = (part.evidence == self._map.evidence) & ~is_seen
        part.evidence[unseen], part.fixed[unseen] = 0, False
        self._map.evidence[:], self._map.fixed[:] = 0, False  # forbidden cells stay
        return bool(unseen.any())

    def _mapped(self) -> Area:
        """Return the part of the area that the map shows."""
        assert self._map is not None
        row, column = self.area.cell(*self._map.place(0, 0))
        height, width = self._map.evidence.shape
        return self.area.window(slice(row, row + height), slice(column, column + width))

    def include(self, place: Place, margin: float = 0.0, *, always: bool = False) -> bool:
        """Extend the area to a place with a margin, m; return False, without a change, where it would be too large.

        A robot must see wherever it is, so the area is `always` extended to the robot. Without a map it then grows with
        the rectangle about all places of the robot, and takes 16 kB of memory for each m².
        """
        area, resolution = self.area, self._parameters.resolution
        first = area.cell(place[0] - margin, place[1] - margin)
        last = area.cell(place[0] + margin, place[1] + margin)
        height, width = area.evidence.shape
        if min(first) >= 0 and last[0] < height and last[1] < width:
            return True
        low, high, shape = np.array(first), np.array(last) + 1, np.array((height, width))
        wide = ceil(MARGIN / resolution)
        if not area.evidence.size:
            before, after = wide - low, high + wide
        else:
            before = np.where(low < 0, wide - low, 0)
            after = np.where(high > shape, high - shape + wide, 0)
        grown = before + after
        is_too_large = (grown > 0) & ((shape + grown) * resolution > self._parameters.largest)
        if is_too_large.any() and not always:
            return False
        # An area without cells begins where the place is, which may be far from its origin.
        sides = (before, after) if area.evidence.size else (np.zeros_like(grown), grown)
        pad = np.stack(sides, axis=1).tolist()
        self.area = Area(
            area.x - int(before[1]) * resolution,
            area.y - int(before[0]) * resolution,
            resolution,
            np.pad(area.evidence, pad),
            np.pad(area.first_hit, pad, constant_values=NEVER),
            np.pad(area.fixed, pad),
            np.pad(area.hit_at, pad, constant_values=-np.inf),
            np.pad(area.theirs_at, pad, constant_values=-np.inf),
            np.pad(area.echo, pad),
            np.pad(area.heard_from, pad, constant_values=np.nan),
            np.pad(area.body, pad),
            np.pad(area.forbidden, pad),
            np.pad(area.surface_x, pad),
            np.pad(area.surface_y, pad),
        )
        return True

    def see(self, reading: ObstRead) -> None:
        """Add the evidence of a reading: where rays passed and where they hit an obstacle."""
        margin = self._parameters.reach + MAX_OFFSET
        self.include(reading.pose[:2], margin, always=True)
        perceived = Perceived.of(reading)
        is_of_scanner = perceived.rays.is_of_scanner
        scanned, sonar = perceived.rays.where(is_of_scanner), perceived.rays.where(~is_of_scanner)
        is_watched = sonar.are_watched_by(scanned)
        rays = self._believed(scanned, reading.pose)
        lone = self._believed(sonar.where(~is_watched), reading.pose)
        part = self.area.around(reading.pose[:2], margin=margin)
        end_x, end_y = rays.end_x[rays.hits], rays.end_y[rays.hits]
        seen = self._cells(part, end_x, end_y)
        part.heard_from[seen] = np.where(part.echo[seen] == 0, np.nan, part.heard_from[seen])
        echo_x, echo_y, directions = echoes(part, lone)
        heard = self._cells(part, echo_x, echo_y)
        part.heard_from[heard] = directions
        hits = np.append(seen[0], heard[0]), np.append(seen[1], heard[1])
        _place_surfaces(part, np.append(end_x, echo_x), np.append(end_y, echo_y), hits)
        votes = np.zeros(part.evidence.shape, np.int8)
        votes.reshape(-1)[free_cells(part, lone)] = PASSED
        for each in (rays, rays.between):
            votes.reshape(-1)[each.passed(part)] = PASSED
        votes[self._cells(part, *seams(end_x, end_y))] = 0
        votes[hits] = HIT
        np.clip(part.evidence + votes, MIN_EVIDENCE, MAX_EVIDENCE, out=part.evidence)
        self._put_bodies(perceived.bodies, reading.stamp)
        if self._parameters.stands and not is_of_scanner.any():
            near = self._within_hearing(reading.pose)
            near.body[:] |= may_be_people(near, reading.stamp, self._parameters.stands)
        self._date(part, hits, reading.stamp)
        self._hear(
            self._believed(sonar, reading.pose),
            self._believed(sonar.where(is_watched), reading.pose),
            perceived,
            reading.stamp,
        )
        if self._has_walkers:
            self._let_go(part, reading.stamp)

    def _believed(self, rays: Rays, pose: Pose) -> BelievedRays:
        return BelievedRays.of(rays, self._parameters.reach, self._parameters.lone_reach, pose)

    def _within_hearing(self, pose: Pose) -> Area:
        return self.area.around(pose[:2], margin=self._parameters.lone_reach + MAX_OFFSET)

    def take_for_walls(self, x: float, y: float, radius: float) -> None:
        """Count the obstacles within a radius, m, as walls, because they have not gone away."""
        part = self.area.around((x, y), margin=radius)
        part.fixed[part.occupied] = True

    def doubt(self, x: float, y: float, radius: float) -> None:
        """Clear the cells within a radius, m."""
        part = self.area.around((x, y), margin=radius)
        part.evidence[:], part.echo[:] = 0, 0
        part.first_hit[:], part.fixed[:] = NEVER, False

    def doubt_unseen(self, x: float, y: float, radius: float, before: float) -> bool:
        """Clear obstacles within a radius, m, that were hit last before s; return whether there were any.

        What a map shows and no ray has hit stays.
        """
        part = self.area.around((x, y), margin=radius)
        is_old = (part.evidence >= OCCUPIED) & (part.hit_at < before) & np.isfinite(part.hit_at)
        part.evidence[is_old] = 0
        part.first_hit[is_old], part.fixed[is_old] = NEVER, False
        return bool(is_old.any())

    def _cells(self, part: Area, x: Floats, y: Floats) -> Cells:
        """Return rows and columns in a part of the area of places within it."""
        area = self.area
        row, column = area.cell(*part.place(0, 0))
        rows, columns = np.floor((y - area.y) / area.resolution), np.floor((x - area.x) / area.resolution)
        return rows.astype(np.intp) - row, columns.astype(np.intp) - column

    def _date(self, part: Area, hits: Cells, stamp: float) -> None:
        """Update the times of hits and the walls."""
        is_free = part.evidence <= SURELY_FREE
        np.copyto(part.first_hit, PASSABLE, where=is_free)
        np.copyto(part.fixed, False, where=is_free)
        first_hit = part.first_hit[hits]
        first_hit[np.isnan(first_hit)] = stamp
        part.first_hit[hits], part.hit_at[hits] = first_hit, stamp
        part.fixed[hits] |= (stamp - first_hit >= self._parameters.settled) & ~part.body[hits]

    def _put_bodies(self, bodies: Bodies, stamp: float) -> None:
        """Replace the cells of bodies; where one moved that is not a wall, there is floor.

        What was hit lately where it may have come from are its traces: a person is known only after some scans.
        """
        self.area.body[:] = False
        for x, y, radius, has_moved in zip(
            bodies.x.tolist(), bodies.y.tolist(), bodies.radius.tolist(), bodies.have_moved.tolist(), strict=True
        ):
            part = self.area.around((x, y), margin=radius + (TRACE_TIME * TRACE_SPEED if has_moved else 0.0))
            height, width = part.body.shape
            across = part.x + (np.arange(width) + 0.5) * part.resolution - x
            along = part.y + (np.arange(height)[:, None] + 0.5) * part.resolution - y
            away = np.hypot(across, along)
            is_within = away <= radius
            part.body[is_within] = True
            if has_moved:
                self._has_walkers = True
                is_trace = ~part.fixed & (stamp - part.hit_at < TRACE_TIME)
                is_trace &= away <= radius + TRACE_SPEED * (stamp - part.hit_at)
                part.theirs_at[is_within | is_trace] = stamp
                part.first_hit[is_within & ~part.fixed] = PASSABLE

    def _hear(self, sonar: BelievedRays, watched: BelievedRays, perceived: Perceived, stamp: float) -> None:
        """Update what sonar hears and the laser sees through.

        An echo comes from somewhere in a wide cone. Where another disc hears that a place is free, it is not there. And
        it is explained by an obstacle of the grid in the cone, such as the frame of a door that the laser has seen.

        Args:
            sonar: All sonar rays.
            watched: Those where the laser looks.
            perceived: With bodies, whose echoes are not those of glass.
            stamp: s.
        """
        near = self._within_hearing(perceived.pose)
        rows, columns = np.nonzero(near.echo != 0)
        x = np.asarray(near.x + (columns + 0.5) * near.resolution, np.float64)
        y = np.asarray(near.y + (rows + 0.5) * near.resolution, np.float64)
        silent = sonar.are_silent(x, y, near.heard_from[rows, columns])
        near.echo[rows[silent], columns[silent]] += PASSED
        bodies, hits = perceived.bodies, watched.hits
        x, y = watched.end_x[hits], watched.end_y[hits]
        directions = np.arctan2(-watched.sines[hits], -watched.cosines[hits])
        apart = np.hypot(x[:, None] - bodies.x, y[:, None] - bodies.y) - bodies.radius
        is_there = (apart.min(axis=1, initial=np.inf) > BESIDE_BODY) & ~sonar.are_silent(x, y, directions)
        is_there &= ~watched.are_explained(near)[hits]
        for each_x, each_y, direction in zip(x[is_there], y[is_there], directions[is_there], strict=True):
            row, column = self.area.cell(each_x, each_y)
            self.area.echo[row, column] = min(self.area.echo[row, column] + ECHO, MAX_ECHO)
            self.area.heard_from[row, column], self.area.hit_at[row, column] = direction, stamp

    def _let_go(self, near: Area, stamp: float) -> None:
        """Remove walking people who are out of view."""
        are_theirs = near.hit_at - WALKER_TIME < near.theirs_at
        near.evidence[are_theirs & (stamp - near.hit_at > self._parameters.gone) & near.occupied & ~near.fixed] = 0


def _place_surfaces(part: Area, x: Floats, y: Floats, cells: Cells) -> None:
    """Update where in their cells the hit surfaces are, before the evidence of the hits is added."""
    share = np.where(part.evidence[cells] >= OCCUPIED, SURFACE_SHARE, 1.0)
    for surface, found, corner, cell in (
        (part.surface_x, x, part.x, cells[1]),
        (part.surface_y, y, part.y, cells[0]),
    ):
        before = surface[cells]
        surface[cells] = before + share * (found - corner - (cell + 0.5) * part.resolution - before)

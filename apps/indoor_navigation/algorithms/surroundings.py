"""Obstacles near the robot: all that is seen now, and for a while what was seen and has left the view.

A scanner looks ahead. When the robot is halfway through a door, the frame is beside it, where no sensor sees it; the
robot must not turn as if the frame were gone. Without a scanner, the same holds for echoes between the cones of the
discs, such as that of a table's leg beside the corner of the hull.

A robot that turns inside a door has often seen the face of the wall only, and never its end beside the door. What was
not seen would have no thickness, and the tail of a long robot would touch it. So walls are remembered with a depth.
"""

import numpy as np

from apps.indoor_navigation.algorithms.bodies import Bodies
from apps.indoor_navigation.algorithms.perception import Perceived
from apps.indoor_navigation.algorithms.pose_history import is_pose_jump
from apps.indoor_navigation.algorithms.rays import Rays, in_robot
from apps.indoor_navigation.algorithms.segments import fit, squares
from apps.indoor_navigation.data import Floats, Ints, Pose

MAX_DISTANCE = 2.5  # m from the robot; goto and avoiding look no farther
MEMORY_TIME = 60.0  # s for which something out of view is remembered
MEMORY_RANGE = 1.2  # m from the sensors within which it must be then: the longest robot and a little more
# m from the sensors, beyond which what a scanner saw is forgotten; a robot that backs up comes near to it again. Places
# of echoes are not so exact that they are worth it: those of people who pass bar the way.
KEPT_RANGE = MAX_DISTANCE
EDGE_RAYS = 2  # on either side of the scan; what they hit leaves the view next and must be remembered
PLACE_SPACING = 0.025  # m between remembered places
MAX_PLACES = 800
CELLS_A_ROW = 1 << 32  # more than any odom is wide, so a row and a column make one number
DEPTHS = (0.05, 0.1)  # m behind a face; hardly any wall is thinner than 0.1 m
FACE_RADIUS = 0.12  # m about a place, within which its neighbours show which way a face goes
MIN_PLACES = 4  # that show it
MIN_SPREAD = 0.03  # m along a face, standard deviation; across a leg there is less
MAX_SLENDERNESS = 0.3  # spread across a face over that along it; ranges are off by 1 cm, and corners are no face


class Surroundings:
    """Places of obstacles in odom."""

    def __init__(self) -> None:
        self.forget()

    def forget(self) -> None:
        """Forget all places, because the origin of odom has changed."""
        self._x = self._y = self._seen_at = np.empty(0)
        self._pose: tuple[Pose, float] | None = None  # of the robot, at s
        self._last = Rays.none()
        self._is_scanned = self._last.is_of_scanner
        self._bodies = Bodies.none()

    def see(self, perceived: Perceived) -> None:
        """Add what the sensors show, and remove remembered places that they show to be free.

        Where the pose of the robot has jumped, all places from before are forgotten.
        """
        stamp, rays = perceived.stamp, perceived.rays
        if self._pose is not None and is_pose_jump(self._pose[0], perceived.pose, stamp - self._pose[1]):
            self.forget()
        self._pose = perceived.pose, stamp
        is_of_scanner = rays.is_of_scanner
        scanned = rays.where(is_of_scanner)
        has_laser = bool(len(scanned.end_x))
        inner = scanned.inner(EDGE_RAYS)
        x, y = self._scanned_before(inner) if has_laser else self._heard_before()
        x, y = np.concatenate((self._x, x)), np.concatenate((self._y, y))
        seen_at = np.concatenate((self._seen_at, np.full(len(x) - len(self._x), stamp)))
        reach = np.full(len(x), MEMORY_RANGE)
        if has_laser:
            reach[: len(self._x)] = KEPT_RANGE
        is_kept = np.asarray((stamp - seen_at < MEMORY_TIME) & (stamp >= seen_at))
        if len(rays.end_x):
            middle = rays.origin_x.mean(), rays.origin_y.mean()
            is_kept &= np.hypot(x - middle[0], y - middle[1]) < reach
            x, y, seen_at = x[is_kept], y[is_kept], seen_at[is_kept]
            is_kept = ~(inner.are_in_view(x, y) if has_laser else rays.are_in_cone(x, y))
        chosen = _thinned(x, y, np.flatnonzero(is_kept))[-MAX_PLACES:]
        self._x, self._y, self._seen_at = x[chosen], y[chosen], seen_at[chosen]
        echoes = rays.where(~is_of_scanner & rays.hits)
        if has_laser:
            # Without echoes of remembered places: a door frame is beside the axis of a disc, not on it.
            remembered = Rays(self._x, self._y, self._x, self._y, np.ones(len(self._x), bool))
            echoes = echoes.unexplained_by(scanned.followed_by(remembered))
        self._last = scanned.followed_by(echoes)
        self._is_scanned, self._bodies = self._last.is_of_scanner, perceived.bodies

    def _scanned_before(self, inner: Rays) -> tuple[Floats, Floats]:
        """Return what the last scan showed and this one does not, with the walls behind it. Echoes are not so exact."""
        rays = self._last.where(self._is_scanned)
        x, y = rays.end_x, rays.end_y
        have_left = np.flatnonzero(rays.hits & ~inner.are_in_view(x, y))
        behind_x, behind_y = behind_faces(rays, have_left)
        return np.concatenate((behind_x, x[have_left])), np.concatenate((behind_y, y[have_left]))

    def _heard_before(self) -> tuple[Floats, Floats]:
        """Return where the last echoes came from, for a robot that has no laser."""
        is_heard = self._last.hits & ~self._is_scanned
        return self._last.end_x[is_heard], self._last.end_y[is_heard]

    def places(self, pose: Pose) -> tuple[Floats, Floats]:
        """Return x and y of all obstacles within `MAX_DISTANCE`, in the frame of a robot at a pose in odom."""
        hits = self._last.hits
        body_x, body_y = self._bodies.outlines()
        x = np.concatenate((self._last.end_x[hits], self._x, body_x))
        y = np.concatenate((self._last.end_y[hits], self._y, body_y))
        x, y = in_robot(pose, x, y)
        is_near = x * x + y * y < MAX_DISTANCE * MAX_DISTANCE
        return x[is_near], y[is_near]


def behind_faces(seen: Rays, chosen: Ints) -> tuple[Floats, Floats]:
    """Return places in the wall behind the ends of the chosen rays of a scan, x and y in odom, m.

    What is too small or too crooked for a face has none.
    """
    rays = np.array((seen.end_x - seen.origin_x, seen.end_y - seen.origin_y))
    away = rays[:, None, :] - rays[:, chosen, None]  # (2, chosen, rays)
    is_near = seen.hits & ((away * away).sum(axis=0) < FACE_RADIUS * FACE_RADIUS)
    moments = squares(rays) @ is_near.T
    normals, _, across = fit(moments)
    count, x, y, xx, yy, _ = moments
    along = (xx + yy) / count - (x * x + y * y) / (count * count) - across * across  # variance, m²
    is_face = (count >= MIN_PLACES) & (along > MIN_SPREAD**2) & (across * across < MAX_SLENDERNESS**2 * along)
    ends = np.array((seen.end_x[chosen], seen.end_y[chosen]))[:, is_face]
    behind = ends[:, None, :] + np.array(DEPTHS)[:, None] * normals[:, None, is_face]
    return behind[0].ravel(), behind[1].ravel()


def _thinned(x: Floats, y: Floats, indices: Ints) -> Ints:
    """Return the indices, in their order, of the last place in each cell of `PLACE_SPACING`.

    When the robot stands, the same places leave the view again and again; they must not replace the others.
    """
    backwards = indices[::-1]
    rows, columns = (np.round(each[backwards] / PLACE_SPACING).astype(np.int64) for each in (y, x))
    cells = rows * CELLS_A_ROW + columns
    order = cells.argsort(kind="stable")
    is_first = np.ones(len(order), bool)
    is_first[1:] = np.diff(cells[order]) != 0
    return np.sort(backwards[order[is_first]])

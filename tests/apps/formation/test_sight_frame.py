"""Places by sight: one frame from what each follower sees, and what becomes of those that see nothing."""

import math

import pytest

from apps.formation.controller import Formation
from apps.formation.members import MemberState, RangeEcho
from apps.formation.settings import FormationSettings
from apps.formation.shapes import ShapeError
from apps.formation.sight_frame import FollowerView, SightFrame
from apps.robot_following.leader import LeaderState
from geometry import Pose2D, Twist2D, integrate

SETTINGS = FormationSettings.load().by_sight
LEADER = Twist2D(0.25, 0.1)
PLACES = {"doc": Pose2D(-1.2, 0.7, 0.2), "grumpy": Pose2D(-1.2, -0.7, -0.1)}  # on the floor
ODOM = {"doc": Pose2D(5.0, -3.0, 2.0), "grumpy": Pose2D(1.0, 8.0, -1.0)}  # origins of odometry on the floor
ECHO = RangeEcho(3, Pose2D(), 1.0)


class Floor:
    """A leader that drives a curve, and followers that stand; blind: those that do not see it."""

    def __init__(self) -> None:
        self.frame = SightFrame("happy", list(PLACES), SETTINGS.sight)
        self.leader, self.time = Pose2D(), 0.0
        self.blind: set[str] = set()
        self.places = dict(PLACES)

    def view(self, name: str) -> FollowerView:
        seen = LeaderState(self.leader.relative_to(ODOM[name]), LEADER.linear, LEADER.angular)
        own = self.places[name].relative_to(ODOM[name])
        return FollowerView(own, Twist2D(), None if name in self.blind else seen, (ECHO,))

    def run(self, seconds: float) -> dict[str, MemberState]:
        states = {}
        for _ in range(round(seconds / 0.1)):
            self.time += 0.1
            self.leader = integrate(self.leader, LEADER, 0.1)
            states = self.frame.update(self.time, {name: self.view(name) for name in PLACES})
        return states


@pytest.fixture
def floor() -> Floor:
    return Floor()


def is_near(states: dict[str, MemberState], name: str, floor: Floor, within: float = 0.01) -> bool:
    """Whether a follower is relative to the leader where it is on the floor."""
    place = states[name].pose.relative_to(states["happy"].pose)
    true = floor.places[name].relative_to(floor.leader)
    return math.dist((place.x, place.y), (true.x, true.y)) < within and abs(place.heading - true.heading) < within


def test_followers_are_where_they_see_themselves_whatever_their_odometry_is(floor: Floor) -> None:
    states = floor.run(5.0)
    assert set(states) == {"happy", "doc", "grumpy"}
    assert all(is_near(states, name, floor) for name in PLACES)
    assert states["happy"].twist == LEADER
    assert states["doc"].echoes == (ECHO,)


def test_nobody_has_a_place_before_all_have_found_the_leader_or_looked_for_it_long_enough(floor: Floor) -> None:
    floor.blind.add("doc")
    assert floor.run(5.0) == {}
    assert set(floor.run(SETTINGS.sight.gather_s)) == {"happy", "grumpy"}


def test_who_does_not_see_the_leader_is_placed_by_its_odometry_and_then_falls_silent(floor: Floor) -> None:
    floor.run(2.0)
    floor.blind.add("doc")
    states = floor.run(10.0)
    assert is_near(states, "doc", floor, 0.05)
    assert states["doc"].heard == states["happy"].heard
    states = floor.run(SETTINGS.sight.blind_s)
    assert states["happy"].heard - states["doc"].heard > SETTINGS.safety.silent_s
    assert states["doc"].echoes == ()  # of unknown places
    floor.blind.clear()
    assert is_near(floor.run(1.0), "doc", floor)


def test_it_looks_to_where_the_others_see_the_leader(floor: Floor) -> None:
    floor.run(2.0)
    floor.blind.add("doc")
    floor.run(4.0)
    ahead = integrate(floor.leader, LEADER, SETTINGS.sight.gaze_s)
    gaze = floor.frame.gaze("doc", floor.view("doc"))
    assert gaze == pytest.approx(floor.places["doc"].bearing_to(ahead.x, ahead.y), abs=0.03)


def test_without_anybody_who_sees_the_leader_all_stand_and_soon_forget_their_places(floor: Floor) -> None:
    floor.run(2.0)
    floor.blind.update(PLACES)
    formation = Formation("happy", list(PLACES), "triangle", SETTINGS, by_sight=True)
    orders = formation.step(floor.time, floor.run(0.2))
    assert orders.told == ("happy, the leader, is not seen; the followers stand",)
    assert set(orders.twists.values()) == {Twist2D()}
    assert floor.frame.gaze("doc", floor.view("doc")) is not None
    floor.run(SETTINGS.sight.unled_s + 0.5)
    assert floor.frame.gaze("doc", floor.view("doc")) is None


def test_a_follower_stands_rather_than_turn_away_from_a_leader_far_aside(floor: Floor) -> None:
    floor.places["doc"] = Pose2D(-1.2, 0.7, 0.9)  # the leader is on its right
    floor.run(0.1)
    assert floor.frame.in_view("doc", Twist2D(0.2, 0.5)) == Twist2D()
    assert floor.frame.in_view("doc", Twist2D(0.2, -0.5)) == Twist2D(0.2, -0.5)
    assert floor.frame.in_view("grumpy", Twist2D(0.2, -0.5)) == Twist2D(0.2, -0.5)


def test_a_shape_from_which_the_target_is_not_seen_is_refused() -> None:
    formation = Formation("happy", list(PLACES), "triangle", SETTINGS, by_sight=True)
    with pytest.raises(ShapeError, match="in line, a place is 90 degrees off the leader's back"):
        formation.set_shape("line")
    assert formation.shape == "triangle"

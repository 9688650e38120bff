from math import cos, hypot, pi, sin
from typing import TYPE_CHECKING

import pytest
from hypothesis import given
from hypothesis import strategies as st

from configs import load
from gateway.odometry import OdometryTracker
from gateway.plausibility import Plausibility
from gateway.settings import Calibration, OdometryErrors
from geometry import Pose2D, Twist2D, integrate, wrap_angle
from p2os import RobotModel, SipCodec, StandardSip

if TYPE_CHECKING:
    from tests.gateway.conftest import MakeBench

MODEL = load(RobotModel, "robots", "p3dx-sh")
CODEC = SipCodec(MODEL)


def heard(pose: Pose2D) -> StandardSip:
    """The pose as the wire carries it: rounded, rolled over."""
    return CODEC.decode(CODEC.encode(StandardSip(x=pose.x, y=pose.y, heading=pose.heading)))


def driven(odometry: OdometryTracker, start: Pose2D, twists: list[Twist2D]) -> Pose2D:
    pose = start
    odometry.update(heard(pose), MODEL)
    for twist in twists:
        pose = integrate(pose, twist, 0.1)
        odometry.update(heard(pose), MODEL)
    return pose


@given(
    st.tuples(st.floats(0, 32), st.floats(0, 32), st.floats(-3, 3)),
    st.lists(st.tuples(st.floats(-2, 2), st.floats(-2, 2)), min_size=1, max_size=60),
)
def test_pose_follows_the_robot_from_where_it_was_first_heard(
    start: tuple[float, float, float], twists: list[tuple[float, float]]
) -> None:
    odometry = OdometryTracker(Calibration(), OdometryErrors())
    origin = Pose2D(*start)
    end = driven(odometry, origin, [Twist2D(*twist) for twist in twists]).relative_to(origin)
    assert hypot(odometry.pose.x - end.x, odometry.pose.y - end.y) < 0.002 + 0.001 * len(twists)
    assert wrap_angle(odometry.pose.heading - end.heading) == pytest.approx(0.0, abs=0.005)
    xx, xy, _, _, yy, _, _, _, hh = odometry.covariance
    assert min(xx, yy, hh) >= 0.0
    assert xx * yy - xy * xy >= -1e-12


def test_calibration_scales_distances_and_turns() -> None:
    odometry = OdometryTracker(Calibration(distance=1.02, heading=0.5), OdometryErrors())
    driven(odometry, Pose2D(5.0, 5.0, 0.0), [Twist2D(1.0, 0.0)] * 10)
    assert odometry.pose.x == pytest.approx(1.02, abs=0.001)
    driven(odometry, Pose2D(6.0, 5.0, 0.0), [Twist2D(0.0, pi / 2)] * 10)
    assert odometry.pose.heading == pytest.approx(pi / 4, abs=0.002)


def test_turns_of_a_gyro_are_believed_against_the_wheels() -> None:
    odometry = OdometryTracker(Calibration(heading=0.5), OdometryErrors())
    odometry.update(heard(Pose2D()), MODEL)
    for step in range(1, 11):  # the wheels slip: they claim a radian where the robot turned a quarter turn
        odometry.update(heard(Pose2D(0.0, 0.0, step / 10)), MODEL, pi / 20)
    assert odometry.pose.heading == pytest.approx(pi / 2)
    odometry.update(heard(Pose2D(1.0 * cos(1.0), 1.0 * sin(1.0), 1.0)), MODEL, 0.0)
    assert odometry.pose.x == pytest.approx(0.0, abs=0.005)
    assert odometry.pose.y == pytest.approx(1.0, abs=0.005)


def test_turns_add_up_beyond_a_full_turn() -> None:
    odometry = OdometryTracker(Calibration(), OdometryErrors())
    driven(odometry, Pose2D(), [Twist2D(0.0, 2 * pi)] * 25)
    assert odometry.turned == pytest.approx(5 * pi, abs=0.01)


def test_uncertainty_grows_with_the_way_and_not_with_time() -> None:
    odometry = OdometryTracker(Calibration(), OdometryErrors())
    driven(odometry, Pose2D(), [Twist2D(0.0, 0.0)] * 10)
    assert odometry.covariance == (0.0,) * 9
    driven(odometry, Pose2D(), [Twist2D(0.5, 0.2)] * 10)
    near = odometry.covariance
    driven(odometry, Pose2D(), [Twist2D(0.5, 0.2)] * 10)
    assert all(far > close > 0.0 for far, close in zip(odometry.covariance[::4], near[::4], strict=True))


class TestReconnect:
    @pytest.mark.parametrize("cut_s", [3.0, 60.0])
    def test_what_the_robot_rolled_while_unheard_is_in_the_pose(self, make_bench: "MakeBench", cut_s: float) -> None:
        bench = make_bench()
        bench.connect()
        for _ in range(4):
            bench.driver.set_velocity(0.3, 0.0, bench.now)
            bench.run(0.4)
        heard_of = bench.driver.odometry.pose.x
        bench.cut = True
        bench.run(cut_s)
        assert not bench.driver.is_connected
        bench.cut = False
        bench.run_until(lambda: bench.driver.is_connected)
        rolled = bench.body.state.left_travel
        assert rolled > heard_of + 0.5
        assert bench.driver.odometry.pose.x == pytest.approx(rolled, abs=0.02)

    @pytest.mark.parametrize(("rolled", "goes_on"), [(0.0, True), (1.5, True), (8.0, False)])
    def test_counters_are_believed_as_far_as_the_robot_can_have_rolled_until_its_watchdog_stopped_it(
        self, rolled: float, goes_on: bool
    ) -> None:
        plausibility = Plausibility(MODEL)
        plausibility.begin_link()
        plausibility.judge(heard(Pose2D(2.0, 1.0, 0.5))._replace(left_velocity=0.4, right_velocity=0.4), 100.0)
        plausibility.begin_link()
        verdict = plausibility.judge(heard(Pose2D(2.0 + rolled, 1.0, 0.5)), 1000.0)
        assert (verdict.doubt, verdict.continues) == (None, goes_on)

    def test_pose_goes_on_from_where_it_was_when_the_counters_were_reset(self, make_bench: "MakeBench") -> None:
        bench = make_bench()
        bench.connect()
        bench.driver.set_velocity(0.3, 0.0, bench.now)
        bench.run(0.5)
        bench.run(2.0)
        before = bench.driver.odometry.pose
        bench.robot.power_cycle()
        bench.run(2.0)
        assert bench.sips[-1].sip.x == pytest.approx(0.0, abs=0.001)
        assert bench.driver.odometry.pose.x == pytest.approx(before.x, abs=0.001)

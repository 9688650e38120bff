"""What the bus shows while something is wrong, and after it."""

from collections import Counter
from collections.abc import Callable
from math import hypot, inf, isfinite
from typing import TYPE_CHECKING

import pytest

from bus import keys
from bus.messages import BatteryState
from geometry import Pose2D

if TYPE_CHECKING:
    from tests.faults.conftest import Mission

MakeMission = Callable[[str], "Mission"]
FAR = 2.5  # m; what the discs ahead see in the room is between this and their reach


def published(mission: "Mission", disc: int) -> set[float]:
    return {round(distance, 3) for number, distance in mission.ranges() if number == disc}


def test_dead_disc_is_published_as_without_echo_and_its_neighbours_as_they_hear(mission: "Mission") -> None:
    mission.forget()
    mission.run(1.0)
    healthy = {disc for disc, distance in mission.ranges() if distance < inf}
    end = mission.fault("sonar-dead:disc=3")
    mission.run(0.5)
    mission.forget()
    mission.run(1.0)
    assert published(mission, 3) == {inf}
    assert {disc for disc, distance in mission.ranges() if distance < inf} == healthy - {3}
    end()
    mission.run(0.5)
    mission.forget()
    mission.run(1.0)
    assert inf not in published(mission, 3)


def test_stuck_disc_is_published_at_its_range_and_makes_a_point(mission: "Mission") -> None:
    end = mission.fault("sonar-stuck:disc=3+4,range=0.8")
    mission.run(0.5)
    mission.forget()
    mission.run(1.0)
    assert published(mission, 3) == published(mission, 4) == {0.8}
    assert 0.8 not in published(mission, 2)
    assert mission.last(keys.SONAR_POINTS).width > 0
    end()
    mission.run(0.5)
    mission.forget()
    mission.run(1.0)
    assert 0.8 not in published(mission, 3)


def test_noisy_discs_are_published_with_their_phantoms_and_within_their_reach(mission: "Mission") -> None:
    mission.fault("sonar-noisy:share=0.5")
    mission.run(0.5)
    mission.forget()
    mission.run(2.0)
    spread = published(mission, 3)
    assert len(spread) > 5, "a robot that stands hears the same echo again and again"
    assert all(0.0 < each <= 5.0 or each == inf for each in spread)


def test_slipping_wheels_part_odometry_from_the_truth_and_the_error_stays(mission: "Mission") -> None:
    start, believed_start = mission.truth, mission.pose
    end = mission.fault("wheel-slipping:factor=0.5")
    mission.drive(3.0)
    mission.run(1.5)
    believed = gone(believed_start, mission.pose)
    assert gone(start, mission.truth) == pytest.approx(believed / 2, rel=0.1)
    end()
    start, believed_start = mission.truth, mission.pose
    mission.drive(2.0)
    mission.run(1.5)
    assert gone(start, mission.truth) == pytest.approx(gone(believed_start, mission.pose), rel=0.05)
    assert mission.counters() == {}, "no SIP was doubted"


def test_one_slipping_wheel_turns_the_robot_and_odometry_goes_straight(mission: "Mission") -> None:
    before = mission.truth.heading, mission.pose.heading
    mission.fault("wheel-slipping:side=right,factor=0.2")
    mission.drive(2.0)
    assert mission.truth.heading - before[0] < -0.3
    assert mission.pose.heading - before[1] == pytest.approx(0.0, abs=0.05)


def test_stalled_wheel_is_published_and_the_robot_tries_again_by_itself(mission: "Mission") -> None:
    end = mission.fault("wheel-stalled:side=right")
    mission.drive(2.0)
    assert any(each.stall_right and not each.stall_left for each in mission.all(keys.BUMPERS))
    end()
    mission.drive(1.0)
    assert mission.drive(2.0) > 0.2
    assert not mission.last(keys.BUMPERS).stall_right


@pytest.mark.parametrize(("segment", "side", "place"), [("front2", "front", 1), ("rear1", "rear", 0)])
def test_stuck_bumper_is_published_in_its_place(mission: "Mission", segment: str, side: str, place: int) -> None:
    end = mission.fault(f"bumper-stuck:segment={segment}")
    mission.run(0.5)
    pressed = mission.last(keys.BUMPERS)
    assert [index for index, each in enumerate(getattr(pressed, side)) if each] == [place]
    assert sum(pressed.front) + sum(pressed.rear) == 1
    end()
    mission.run(0.5)
    released = mission.last(keys.BUMPERS)
    assert not any((*released.front, *released.rear))


def test_low_voltage_is_published_at_once_and_so_is_the_batterys_own_afterwards(mission: "Mission") -> None:
    healthy = mission.last(keys.BATTERY).voltage
    end = mission.fault("low-battery:volts=20.5")
    mission.run(0.5)
    assert mission.last(keys.BATTERY).voltage == pytest.approx(20.5, abs=0.05)
    end()
    mission.run(0.5)
    assert mission.last(keys.BATTERY).voltage == pytest.approx(healthy, abs=0.3)


def test_charger_is_published_as_charging(mission: "Mission") -> None:
    end = mission.fault("charger-plugged")
    mission.run(1.0)
    assert mission.last(keys.BATTERY).power_supply_status == BatteryState.POWER_SUPPLY_STATUS_CHARGING
    end()
    mission.run(1.0)
    assert mission.last(keys.BATTERY).power_supply_status == BatteryState.POWER_SUPPLY_STATUS_DISCHARGING


def test_pressed_stop_is_published_as_an_emergency_stop_without_motors(mission: "Mission") -> None:
    end = mission.fault("stop-pressed")
    mission.run(0.5)
    state = mission.last(keys.STATE)
    assert (state.estop, state.motors) == (True, False)
    end()
    mission.run(0.5)
    state = mission.last(keys.STATE)
    assert (state.estop, state.motors) == (True, False), "the robot's own stop holds until somebody enables it"
    mission.enable()
    state = mission.last(keys.STATE)
    assert (state.estop, state.motors) == (False, True)


def test_short_brown_out_is_noticed_at_once_and_the_pose_goes_on(mission: "Mission") -> None:
    mission.drive(2.0)
    mission.fault("brown-out")
    mission.run(4.0)
    connections = [state.connection for state in mission.all(keys.STATE)]
    assert connections[-1] == "connected"
    assert "connecting" in connections
    assert mission.counters()["lost: the controller was reset"] == 1
    believed = mission.pose
    mission.drive(1.0)
    assert gone(believed, mission.pose) < 0.3, "the robot counts from zero again, the bus does not"
    assert gone(Pose2D(0.0, 0.0, 0.0), believed) > 0.2


def test_failed_gyro_gives_no_turn_rate_until_it_measures_again(make_mission: MakeMission) -> None:
    mission = make_mission("gyro")
    end = mission.fault("gyro-failed")
    mission.run(0.5)
    mission.forget()
    mission.run(1.0)
    assert mission.count(keys.IMU) == 0
    end()
    mission.run(2.0)
    rates = [each.angular_velocity.z for each in mission.all(keys.IMU)]
    assert rates
    assert all(abs(rate) < 0.05 for rate in rates), "it stands; what a dead gyro read is no turn rate"


def test_dirty_window_shortens_the_lasers_sight_until_it_is_wiped(make_mission: MakeMission) -> None:
    mission = make_mission("laser")
    mission.run(2.0)
    mission.forget()
    mission.run(1.0)
    clean = echoes(mission)
    end = mission.fault("laser-dirty:dirt=0.95")  # a reach of 32 m shrinks to 1.6 m
    mission.run(1.0)
    mission.forget()
    mission.run(1.0)
    assert echoes(mission) == 0 < clean
    assert mission.count(keys.SCAN) > 0, "scans go on; where nothing comes back there is no echo"
    end()
    mission.run(1.0)
    mission.forget()
    mission.run(1.0)
    assert echoes(mission) == clean


def test_noise_is_counted_and_no_wrong_pose_is_published(mission: "Mission") -> None:
    mission.fault("line-noisy:rate=0.0005")
    mission.forget()
    start = mission.truth  # where odometry began as well: it has not moved yet
    for _ in range(20):
        mission.drive(0.5, 0.1)
        assert gone(start.compose(mission.pose), mission.truth) < 0.1
    counted = mission.counters()
    assert sum(count for key, count in counted.items() if key.startswith("damaged")) > 3
    assert mission.count(keys.ODOM) > 40, "the sound ones are published"


@pytest.mark.parametrize(
    ("spec", "reason"),
    [
        ("line-cut", "the robot fell silent"),
        ("line-frozen", "the robot fell silent"),
        ("line-garbled", "the robot fell silent"),
        ("line-half-duplex:toward=host", "the robot fell silent"),
        ("frozen-firmware", "the robot fell silent"),
    ],
)
def test_silence_is_counted_once_and_odometry_stops_until_it_is_over(
    mission: "Mission", spec: str, reason: str
) -> None:
    end = mission.fault(spec)
    mission.run(2.0)
    mission.forget()
    mission.run(3.0)
    rates = Counter({topic: mission.count(topic) for topic in (keys.ODOM, keys.SONAR, keys.BUMPERS, keys.BATTERY)})
    assert not +rates
    assert mission.count(keys.STATE) >= 3
    assert {key: count for key, count in mission.counters().items() if key.startswith("lost")} == {f"lost: {reason}": 1}
    end()
    mission.run(5.0)
    mission.forget()
    mission.run(1.0)
    assert mission.count(keys.ODOM) >= 9


def echoes(mission: "Mission") -> int:
    """How many beams of the last scan came back."""
    return sum(map(isfinite, mission.last(keys.SCAN).ranges))


def gone(start: Pose2D, end: Pose2D) -> float:
    return hypot(end.x - start.x, end.y - start.y)

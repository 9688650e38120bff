"""Driving: speeds, distances, headings, limits and the watchdog, by what the robot itself reports.

Tolerances leave room for a real robot on a real floor: a tenth of a speed, 1 cm of a way, 1.5 degrees.
"""

import itertools
import math
from collections.abc import Callable, Sequence

import pytest

from pty_tests.client import (
    CONFIG,
    DCHEAD,
    DHEAD,
    ENABLE,
    ESTOP,
    HEAD,
    MOVE,
    PULSE,
    ROTATE,
    RVEL,
    SETA,
    SETO,
    SETRV,
    SETV,
    STOP,
    VEL,
    Client,
    command,
    frame,
)
from pty_tests.firmware import Firmware
from pty_tests.models import ANGLE, Model
from pty_tests.packets import CONFIGPAC, Sip, parse_configuration, travel_between, turn_between

pytestmark = pytest.mark.moves

# Raw units with odd factors for distance and speed, and plain mm.
UNITS = pytest.mark.emulate("powerbot", "p3dx-sh", "amigo")
# Enough where units are no question.
CLOSELY = pytest.mark.emulate("powerbot")


@pytest.fixture
def times(driven: Client, firmware: Firmware) -> dict[str, float]:
    """The robot's own SIP cycle and watchdog time, s."""
    firmware.require(CONFIG)
    driven.send(CONFIG)
    fields = parse_configuration(driven.next(CONFIGPAC))
    return {name: int(fields[name]) / 1000 for name in ("sip_cycle", "watchdog")}


def wheels(sip: Sip, model: Model) -> tuple[float, float]:
    """Left and right wheel speed, mm/s."""
    return sip.left * model.speed, sip.right * model.speed


def runs_at(left: float, right: float, model: Model) -> Callable[[Sip], bool]:
    """A claim about a SIP: both wheels are within 5 % and one count of these speeds, mm/s."""

    def holds(sip: Sip) -> bool:
        pairs = zip(wheels(sip, model), (left, right), strict=True)
        return all(abs(speed - wanted) <= abs(wanted) * 0.05 + 2 for speed, wanted in pairs)

    return holds


def distance(sips: Sequence[Sip], model: Model) -> float:
    """Way between the first and the last SIP as the crow flies, mm."""
    x, y = travel_between(sips[0].x, sips[-1].x), travel_between(sips[0].y, sips[-1].y)
    return math.hypot(x, y) * model.distance


def degrees_turned(sips: Sequence[Sip]) -> float:
    """Turn from the first SIP to the last, followed from one to the next, degrees."""
    return ANGLE * sum(turn_between(a.heading, b.heading) for a, b in itertools.pairwise(sips))


def heads_for(setpoint: int) -> Callable[[Sip], bool]:
    """A claim about a SIP: CONTROL is within 1.5 degrees of this heading, counts."""
    return lambda sip: abs(turn_between(sip.control, setpoint)) * ANGLE <= 1.5


def stopped(robot: Client) -> Sip:
    return robot.sip(lambda sip: sip.at_rest, "SIP at rest", 6.0)


def finished(robot: Client) -> Sip:
    """The SIP at the end of a motion that has just been ordered."""
    robot.sip(lambda sip: not sip.at_rest, "SIP that shows the motion begun", 2.0)
    return stopped(robot)


@UNITS
@pytest.mark.parametrize("speed", [200, -200])
def test_vel_turns_both_wheels_at_its_speed_and_the_odometry_agrees(
    driven: Client, model: Model, times: dict[str, float], speed: int
) -> None:
    driven.send(VEL, speed)  # a negative one travels as a magnitude of type 0x1B
    driven.sip(runs_at(speed, speed, model), f"SIP with both wheels at {speed} mm/s")
    sips = driven.sips(9)
    assert all(sip.moving for sip in sips), "a moving robot sends type 0x33"
    for wheel in (0, 1):
        assert sum(wheels(sip, model)[wheel] for sip in sips) / len(sips) == pytest.approx(speed, rel=0.1)
    assert distance(sips, model) == pytest.approx(200 * 8 * times["sip_cycle"], rel=0.1)
    assert travel_between(sips[0].x, sips[-1].x) * speed > 0
    assert abs(degrees_turned(sips)) < 2
    driven.send(VEL, 0)
    assert stopped(driven).motors


@pytest.mark.emulate("powerbot", "p3dx-sh")  # ARCOS recomposes the two wheels into translation and rotation
@pytest.mark.parametrize(
    ("payload", "left", "right"),
    [
        ("20 3B 0A 0A", 200, 200),
        ("20 3B FD 05", 100, -60),  # Player: the two bytes as they are
        ("20 1B FB 02", -60, 100),  # ARIA: 0xFD05 as a signed number, so its magnitude 0x02FB
        ("20 1B 0A 09", -200, -200),
    ],
    ids=["forward", "Player, right back", "ARIA, left back", "ARIA, both back"],
)
def test_vel2_sets_each_wheel(driven: Client, model: Model, payload: str, left: int, right: int) -> None:
    driven.write(frame(bytes.fromhex(payload)))
    driven.sip(runs_at(left, right, model), f"SIP with the wheels at {left} and {right} mm/s")
    assert all(runs_at(left, right, model)(sip) for sip in driven.sips(3))


@UNITS
@pytest.mark.needs
@pytest.mark.parametrize(("number", "rate"), [(RVEL, 30), (ROTATE, -30)], ids=["RVEL", "ROTATE back"])
def test_the_robot_turns_on_the_spot_at_the_rate_asked_for(
    driven: Client, model: Model, times: dict[str, float], number: int, rate: int
) -> None:
    rim = math.radians(rate) * model.track / 2
    driven.send(number, rate)
    driven.sip(runs_at(-rim, rim, model), f"SIP with the wheels at {rim:.0f} mm/s against each other")
    sips = driven.sips(9)
    assert degrees_turned(sips) == pytest.approx(rate * 8 * times["sip_cycle"], rel=0.1)
    assert distance(sips, model) < 30


@CLOSELY
def test_heading_commands_turn_to_where_they_say_and_control_shows_it(driven: Client) -> None:
    for number, value, wanted in (
        (HEAD, 90, 90),
        (DHEAD, -60, 30),  # from the present heading
        (DCHEAD, -30, 0),  # from the last setpoint
        (HEAD, 270, -90),
    ):
        driven.send(number, value)
        setpoint = round(wanted / ANGLE)
        driven.sip(heads_for(setpoint), f"SIP with the setpoint at {wanted} degrees", 1.0)
        end = finished(driven)
        assert ANGLE * turn_between(setpoint, end.heading) == pytest.approx(0, abs=1.5)


@CLOSELY
def test_ten_commands_in_one_write_all_count(driven: Client) -> None:
    driven.write(command(DCHEAD, 3) * 10)
    assert finished(driven).heading * ANGLE == pytest.approx(30, abs=1.5)


@CLOSELY
def test_translation_and_rotation_do_not_disturb_each_other(driven: Client, model: Model) -> None:
    driven.send(VEL, 150)
    driven.send(HEAD, 45)
    driven.sip(lambda sip: abs(sip.heading * ANGLE - 45) < 1.5, "SIP at 45 degrees", 4.0)
    driven.sip(runs_at(150, 150, model), "SIP going straight on at 150 mm/s")


@UNITS
@pytest.mark.parametrize("way", [300, -300])
def test_move_ends_where_it_should_and_the_counter_rolls_over(driven: Client, model: Model, way: int) -> None:
    start = driven.sip()
    driven.send(MOVE, way)
    end = finished(driven)
    assert travel_between(start.x, end.x) * model.distance == pytest.approx(way, abs=10)
    assert (end.x > 16384) == (way < 0), "X is a counter of 15 bits"
    assert end.x < 32768
    assert end.y < 50 or end.y > 32718


@CLOSELY
def test_seto_after_a_drive_puts_the_odometry_to_zero(driven: Client, model: Model) -> None:
    driven.send(VEL, 200)
    driven.sip(lambda sip: sip.x * model.distance > 100, "SIP beyond 100 mm")
    driven.send(STOP)
    stopped(driven)
    driven.write(bytes.fromhex("FA FB 04 07 3B 07 3B"))  # as Player and ROS send it: a type and no value
    driven.sip(lambda sip: (sip.x, sip.y, sip.heading) == (0, 0, 0), "SIP at the origin", 1.0)
    assert SETO == 7


@CLOSELY
@pytest.mark.needs
@pytest.mark.parametrize(
    ("number", "least", "most"),
    [(STOP, 150, 270), (ESTOP, 0, 100)],  # 400 mm/s at 400 mm/s2 takes 200 mm
    ids=["STOP brakes as SETA says", "ESTOP brakes harder"],
)
def test_stopping(driven: Client, model: Model, number: int, least: float, most: float) -> None:
    driven.send(VEL, 400)
    sips = [driven.sip(runs_at(400, 400, model), "SIP at 400 mm/s")]
    driven.send(number)
    while not sips[-1].at_rest:
        sips.append(driven.sip())
        assert len(sips) < 100, "the robot does not stop"
    # The command met the robot up to a cycle after the last SIP at full speed: 40 mm. On a busy machine there are more
    # of these, because the command is sent late.
    last = max(index for index, sip in enumerate(sips) if runs_at(400, 400, model)(sip))
    assert least <= distance([sips[last], sips[-1]], model) <= most
    assert all(sip.at_rest for sip in driven.sips(3))
    assert sips[-1].motors


@CLOSELY
def test_setv_limits_the_commands_that_follow_it(driven: Client, model: Model) -> None:
    driven.send(SETV, 150)
    driven.send(VEL, 400)
    driven.sip(runs_at(150, 150, model), "SIP at 150 mm/s")
    driven.send(SETV, 300)
    assert all(runs_at(150, 150, model)(sip) for sip in driven.sips(5)), "SETV touched a setpoint that was active"
    driven.send(VEL, 400)
    driven.sip(runs_at(300, 300, model), "SIP at 300 mm/s")


@CLOSELY
def test_setrv_limits_the_turn_to_a_heading(driven: Client, model: Model) -> None:
    driven.send(SETRV, 30)
    driven.send(HEAD, 40)
    rim = math.radians(30) * model.track / 2
    driven.sip(runs_at(-rim, rim, model), "SIP that shows the robot turn at 30 degrees a second")
    assert stopped(driven).heading * ANGLE == pytest.approx(40, abs=1.5)


@CLOSELY
def test_seta_shapes_the_start_and_the_end_of_a_drive(driven: Client, model: Model, times: dict[str, float]) -> None:
    for number, value in ((SETA, 200), (SETA, -100), (VEL, 200)):
        driven.send(number, value)
    up = samples_until(driven, lambda sip: sip.left * model.speed >= 190)
    driven.send(VEL, 0)
    down = samples_until(driven, lambda sip: sip.at_rest)
    assert up * times["sip_cycle"] == pytest.approx(1.0, abs=0.35)
    assert down * times["sip_cycle"] == pytest.approx(2.0, abs=0.5)


def samples_until(robot: Client, holds: Callable[[Sip], bool]) -> int:
    """How many SIPs from now, on the robot's own clock, until one makes the claim true."""
    robot.forget()
    for count in range(1, 60):
        if holds(robot.sip()):
            return count
    raise AssertionError("not within 60 SIPs")


@CLOSELY
def test_silence_stops_the_robot_and_the_next_packet_resumes(
    driven: Client, model: Model, times: dict[str, float]
) -> None:
    driven.send(VEL, 150)
    driven.sip(runs_at(150, 150, model), "SIP at 150 mm/s")
    driven.send(PULSE)
    cycles = times["watchdog"] / times["sip_cycle"]
    silent = driven.sips(round(cycles) + 15, pulse=False)
    driving = sum(runs_at(150, 150, model)(sip) for sip in silent)
    assert driving == pytest.approx(cycles, abs=4)
    assert silent[-1].at_rest
    assert silent[-1].motors, "the watchdog stops, it does not disable"
    driven.send(PULSE)
    driven.sip(runs_at(150, 150, model), "SIP at 150 mm/s again")


@CLOSELY
def test_a_velocity_while_the_motors_are_off_turns_no_wheel(driven: Client) -> None:
    driven.send(ENABLE, 0)
    driven.motors_become(False)
    driven.send(VEL, 200)
    assert all(sip.at_rest for sip in driven.sips(4))


@CLOSELY
def test_disabling_the_motors_ends_a_drive(driven: Client, model: Model) -> None:
    driven.send(VEL, 200)
    driven.sip(runs_at(200, 200, model), "SIP at 200 mm/s")
    driven.send(ENABLE, 0)
    assert not stopped(driven).motors

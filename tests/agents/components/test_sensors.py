"""What the components of the sensors make of their messages: SI and radians, and null where nothing was measured."""

from collections.abc import Callable
from math import atan2, inf, nan, pi
from typing import Any

import numpy as np
import pytest

from bus import keys
from bus.messages import (
    NS_PER_S,
    BatteryState,
    Bumpers,
    Compass,
    Header,
    InputsOutputs,
    JointState,
    Joy,
    LaserScan,
    Range,
    RangeArray,
    Vector3,
    header,
)
from tests.agents.components.bench import Bench, odometry

MakeBench = Callable[..., Bench]

STAMP = 1234.5


def stamped(frame: str = "base_link", at: float = STAMP) -> Header:
    return header(round(at * NS_PER_S), f"happy/{frame}")


def ranges(kind: str, least: float = 0.1, at: float = STAMP, **measured: float) -> RangeArray:
    """Ranges by the number of the sensor, given as `n3=1.5`."""
    return RangeArray(
        stamped(at=at),
        [
            Range(
                header=stamped(f"{kind}_{number[1:]}", at),
                radiation_type=Range.ULTRASOUND,
                field_of_view=0.26,
                min_range=least,
                max_range=5.0,
                range=value,
                variance=0.0,
            )
            for number, value in measured.items()
        ],
    )


def scan(*beams: float, angle_min: float = -pi / 2, increment: float = pi / 2) -> LaserScan:
    return LaserScan(
        header=stamped("laser"),
        angle_min=angle_min,
        angle_max=angle_min + (len(beams) - 1) * increment,
        angle_increment=increment,
        time_increment=0.0,
        scan_time=0.1,
        range_min=0.01,
        range_max=32.0,
        ranges=np.array(beams, np.float32),
        intensities=np.array([], np.float32),
    )


def battery(voltage: float, fraction: float, status: int) -> BatteryState:
    unknown = dict.fromkeys(("temperature", "current", "charge", "capacity", "design_capacity"), nan)
    return BatteryState(
        header=stamped(),
        voltage=voltage,
        **unknown,
        percentage=fraction,
        power_supply_status=status,
        power_supply_health=0,
        power_supply_technology=0,
        present=True,
        cell_voltage=np.array([], np.float32),
        cell_temperature=np.array([], np.float32),
        location="",
        serial_number="",
    )


def joints(*names: str) -> JointState:
    count = np.ones(len(names))
    return JointState(
        header=stamped(), name=[f"happy/{name}" for name in names], position=count, velocity=count, effort=count[:0]
    )


class TestSonar:
    DISCS = ({"number": 3, "x": 0.1, "y": 0.2, "heading": pi / 2}, {"number": 12, "x": -0.2, "y": 0.0, "heading": pi})

    @pytest.fixture
    def bench(self, make_bench: MakeBench) -> Bench:
        return make_bench("sonar", discs=list(self.DISCS))

    def test_all_discs_are_told_though_they_take_turns(self, bench: Bench) -> None:
        bench.say(keys.SONAR, ranges("sonar", n3=1.0, n12=4.0))
        bench.say(keys.SONAR, ranges("sonar", at=STAMP + 0.1, n4=inf))
        assert bench.value() == {
            "stamp": STAMP + 0.1,
            "ranges": {"3": 1.0, "4": None, "12": 4.0},
            "nearest": 1.0,
            "bearing": pytest.approx(atan2(1.2, 0.1), abs=1e-3),
        }

    def test_what_is_a_second_old_is_forgotten(self, bench: Bench) -> None:
        bench.say(keys.SONAR, ranges("sonar", n3=1.0))
        bench.say(keys.SONAR, ranges("sonar", at=STAMP + 1.1, n12=4.0))
        result = bench.value()
        assert (result["ranges"], result["nearest"]) == ({"12": 4.0}, 4.0)
        assert abs(result["bearing"]) == pytest.approx(pi, abs=1e-3)

    def test_without_an_echo_nothing_is_near(self, bench: Bench) -> None:
        bench.say(keys.SONAR, ranges("sonar", n3=inf, n12=nan))
        result = bench.value()
        assert result["ranges"] == {"3": None, "12": None}
        assert (result["nearest"], result["bearing"]) == (None, None)

    def test_an_echo_of_a_disc_that_nobody_has_described_has_no_bearing(self, bench: Bench) -> None:
        bench.say(keys.SONAR, ranges("sonar", n9=2.0))
        result = bench.value()
        assert (result["nearest"], result["bearing"]) == (2.0, None)

    def test_a_clock_that_is_set_back_loses_nothing_but_the_past(self, bench: Bench) -> None:
        bench.say(keys.SONAR, ranges("sonar", n3=1.0))
        bench.say(keys.SONAR, ranges("sonar", at=STAMP - 500.0, n12=4.0))
        assert bench.value()["ranges"] == {"12": 4.0}


class TestLaser:
    def test_a_scan_tells_every_beam_and_where_the_nearest_echo_is(self, make_bench: MakeBench) -> None:
        bench = make_bench("laser")
        bench.say(keys.SCAN, scan(3.0, inf, 1.5, increment=pi / 4))
        assert bench.value() == {
            "stamp": STAMP,
            "angle_min": pytest.approx(-pi / 2, abs=1e-6),
            "angle_increment": pytest.approx(pi / 4, abs=1e-6),
            "ranges": [3.0, None, 1.5],
            "nearest": 1.5,
            "bearing": 0.0,
        }

    @pytest.mark.parametrize("beams", [(), (inf,), (nan, inf, nan)])
    def test_where_nothing_is_nothing_is_near(self, make_bench: MakeBench, beams: tuple[float, ...]) -> None:
        bench = make_bench("laser")
        bench.say(keys.SCAN, scan(*beams))
        result = bench.value()
        assert result["ranges"] == [None] * len(beams)
        assert (result["nearest"], result["bearing"]) == (None, None)

    def test_the_bearing_is_seen_from_the_robot_wherever_the_laser_sits(self, make_bench: MakeBench) -> None:
        bench = make_bench("laser", geometry={"x": -0.5, "y": 0.0, "heading": pi})
        bench.say(keys.SCAN, scan(2.0, inf, inf))
        assert bench.value()["bearing"] == pytest.approx(atan2(2.0, -0.5), abs=1e-3)


class TestInfrared:
    def test_a_switch_that_sees_something_says_that_it_is_there(self, make_bench: MakeBench) -> None:
        bench = make_bench("ir")
        bench.say(keys.IR, ranges("ir", 0.0, n0=inf, n1=-inf, n2=nan))
        assert bench.value() == {"stamp": STAMP, "ranges": {"0": None, "1": 0.0, "2": None}, "nearest": 0.0}

    def test_one_that_measures_is_told_as_it_is(self, make_bench: MakeBench) -> None:
        bench = make_bench("ir")
        bench.say(keys.IR, ranges("ir", n0=0.7, n1=0.4))
        assert bench.value()["nearest"] == 0.4


class TestPlainOnes:
    def test_bumpers_tell_what_touches(self, make_bench: MakeBench) -> None:
        bench = make_bench("bumpers")
        bench.say(keys.BUMPERS, Bumpers(stamped(), (False, False), (False, True), stall_left=True))
        assert bench.value() == {
            "stamp": STAMP,
            "front": [False, False],
            "rear": [False, True],
            "stall_left": True,
            "stall_right": False,
            "pressed": True,
        }

    def test_a_stall_presses_no_bumper(self, make_bench: MakeBench) -> None:
        bench = make_bench("bumpers")
        bench.say(keys.BUMPERS, Bumpers(stamped(), (False,), (), stall_right=True))
        assert bench.value()["pressed"] is False

    @pytest.mark.parametrize(
        ("fraction", "status", "told", "charging"),
        [
            (0.5, BatteryState.POWER_SUPPLY_STATUS_CHARGING, 0.5, True),
            (nan, BatteryState.POWER_SUPPLY_STATUS_DISCHARGING, None, False),
            (1.0, BatteryState.POWER_SUPPLY_STATUS_FULL, 1.0, False),
        ],
    )
    def test_the_battery_tells_how_full_it_is_where_that_is_known(
        self, make_bench: MakeBench, fraction: float, status: int, told: float | None, charging: bool
    ) -> None:
        bench = make_bench("battery")
        bench.say(keys.BATTERY, battery(12.5, fraction, status))
        assert bench.value() == {"stamp": STAMP, "voltage": 12.5, "fraction": told, "charging": charging}

    def test_ports_are_told_lowest_bit_first(self, make_bench: MakeBench) -> None:
        bench = make_bench("io")
        bench.say(keys.IO, InputsOutputs(stamped(), (True, False), (False,), (1.25, nan)))
        assert bench.value() == {
            "stamp": STAMP,
            "digital_in": [True, False],
            "digital_out": [False],
            "analog_in": [1.25, None],
        }

    def test_the_joystick_tells_how_it_is_held(self, make_bench: MakeBench) -> None:
        bench = make_bench("joystick")
        bench.say(keys.JOYSTICK, Joy(stamped(), np.array([-0.5, 1.0, 0.0], np.float32), np.array([0, 1], np.int32)))
        assert bench.value() == {"stamp": STAMP, "axes": [-0.5, 1.0, 0.0], "buttons": [0, 1]}

    def test_the_base_tells_where_it_is_and_how_fast(self, make_bench: MakeBench) -> None:
        bench = make_bench("base")
        bench.say(keys.ODOM, odometry(1.0, -2.0, 0.5))
        expected = {"stamp": 0.0, "x": 1.0, "y": -2.0, "heading": 0.5, "linear": 0.25, "angular": -0.5}
        assert bench.value() == expected

    def test_a_base_that_has_lost_count_goes_nowhere(self, make_bench: MakeBench) -> None:
        bench = make_bench("base")
        bench.say(keys.ODOM, odometry(nan, 0.0, 0.0))
        assert bench.value()["x"] is None
        assert bench.ask("go_to", x=1.0, y=0.0).why == "happy has lost count of where it is"

    def test_a_place_beyond_all_reach_is_refused(self, make_bench: MakeBench) -> None:
        bench = make_bench("base")
        bench.say(keys.ODOM, odometry(0.0, 0.0, 0.0))
        assert bench.ask("go_to", x=1e9, y=0.0).why == "(1e+09, 0) is 1000000000 m away; name a place within 1000 m"


class TestGeneric:
    """An element that has no class of its own."""

    def test_its_message_is_told_as_it_is_but_for_numbers_that_are_none(self, make_bench: MakeBench) -> None:
        bench = make_bench("compass", streams=["happy/compass"], commands=[])
        field = Vector3(x=1e-5, y=nan, z=-inf)
        bench.say(keys.COMPASS, Compass(stamped(), 0.5, nan, 0.0, field, 25.0, 0))
        assert bench.value() == {
            "stamp": STAMP,
            "heading": 0.5,
            "pitch": None,
            "roll": 0.0,
            "magnetic_field": {"x": 1e-5, "y": None, "z": None},
            "temperature": 25.0,
            "errors": 0,
        }

    def test_its_commands_are_requests_of_their_names(self, make_bench: MakeBench) -> None:
        bench = make_bench("power", streams=[], commands=["happy/command/power"])
        bench.obey(keys.POWER)
        assert bench.value("power", output="laser", on=True, token="t-1") == {"ok": True}
        assert bench.obeyed == [("command/power", {"output": "laser", "on": True, "token": "t-1"})]
        assert bench.ask().why == "power@happy has no readings"

    def test_the_gateway_judges_what_they_take(self, make_bench: MakeBench) -> None:
        bench = make_bench("lcd", streams=[], commands=["happy/command/lcd"])
        bench.obey(keys.LCD, refusal="lcd needs text: text")
        outcome = bench.ask("lcd")
        assert (outcome.agreed, outcome.why) == (False, "lcd needs text: text")

    @pytest.mark.parametrize("key", ["happy/unheard-of", "unheard-of", "happy/lease/state", "happy/cmd_vel", ""])
    def test_keys_that_it_cannot_use_are_left_alone(self, make_bench: MakeBench, key: str) -> None:
        bench = make_bench("toaster", streams=[key], commands=[key])
        assert bench.component.describe()["requests"] == ["read"]

    def test_encoders_tell_of_the_wheels_alone(self, make_bench: MakeBench) -> None:
        bench = make_bench("encoders", streams=["happy/joint_states"], commands=[])
        heard = bench.results()
        wheels = ["happy/left_wheel", "happy/right_wheel"]
        bench.say(keys.JOINT_STATES, joints("left_wheel", "right_wheel"))
        bench.say(keys.JOINT_STATES, joints("arm_joint_1"))
        assert bench.value()["name"] == wheels
        assert [result["name"] for result in heard] == [wheels]


class TestRequests:
    @pytest.mark.parametrize(
        ("element", "name", "arguments", "command"),
        [
            ("sonar", "power", {"on": False}, ("command/sonar", {"on": False})),
            ("io", "output", {"mask": 3, "value": 1}, ("command/output", {"mask": 3, "value": 1})),
            ("sound", "play", {"notes": [[60, 0.2]]}, ("command/sound", {"notes": [[60, 0.2]]})),
            ("sound", "play", {"number": 3}, ("command/sound", {"number": 3})),
            ("sound", "mute", {}, ("command/sound", {"on": False})),
            ("sound", "mute", {"on": False}, ("command/sound", {"on": True})),
        ],
    )
    def test_requests_become_the_gateways_commands(
        self,
        make_bench: MakeBench,
        element: str,
        name: str,
        arguments: dict[str, Any],
        command: tuple[str, dict[str, Any]],
    ) -> None:
        bench = make_bench(element)
        (topic,) = [topic for topic in keys.TOPICS if topic.suffix == command[0]]
        bench.obey(topic)
        bench.value(name, **arguments)
        assert bench.obeyed == [command]

import re
from collections.abc import Callable
from math import inf, nan, pi, radians
from typing import Any

import pytest

import configs
from p2os import FIRMWARES, Family, LaserMount, RobotModel, SonarDisc
from p2os.robot_model import InfraredSensor

NAMES = configs.names("robots")


@pytest.fixture
def table() -> dict[str, Any]:
    return configs.read(configs.find("robots", "powerbot-sh"))


def test_there_is_a_model_for_every_known_subtype() -> None:
    pioneers_2 = ["p2dx", "p2de", "p2ce", "p2df", "p2d8", "p2d8+", "p2at", "p2at8", "p2at8+", "p2it"]
    pioneers_3 = ["p3dx", "p3dx-sh", "p3at", "p3at-sh", "p3atiw-sh"]
    peoplebots = ["p2pb", "p2pp", "perfpb", "perfpb+", "peoplebot-sh"]
    others = ["patrolbot-sh", "powerbot", "powerbot-sh", "powerbot-sh-uarcs", "amigo", "amigo-sh"]
    assert sorted(pioneers_2 + pioneers_3 + peoplebots + others) == NAMES


@pytest.mark.parametrize("name", NAMES)
def test_a_model_makes_sense(model_of: Callable[[str], RobotModel], name: str) -> None:
    model = model_of(name)
    assert model.name == name
    assert model.robot_class == "Pioneer"
    assert model.length == pytest.approx(model.length_front + model.length_rear, abs=0.001)
    assert 0.1 < model.wheel_track < 0.7
    assert 0.05 < model.wheel_diameter < 0.3
    assert 1 < model.mass < 150
    assert model.battery_nominal in (12, 24)
    assert 0.9 < model.max_velocity <= 2.2
    assert pi < model.max_rotation < 9
    assert len({disc.number for disc in model.sonar}) == len(model.sonar)
    assert all(0 <= disc.number < 32 and abs(disc.x) + abs(disc.y) > 0 for disc in model.sonar)
    assert [disc.number for disc in model.sonar] == sorted(disc.number for disc in model.sonar)


@pytest.mark.parametrize(
    ("name", "discs", "front", "rear"),
    [
        ("powerbot", 28, 7, 5),
        ("powerbot-sh-uarcs", 14, 7, 5),
        ("patrolbot-sh", 16, 6, 6),
        ("p3dx-sh", 16, 0, 0),
        ("amigo", 8, 0, 0),
    ],
)
def test_only_real_discs_and_fitted_bumpers_count(
    model_of: Callable[[str], RobotModel], name: str, discs: int, front: int, rear: int
) -> None:
    model = model_of(name)
    assert (len(model.sonar), model.front_bumpers, model.rear_bumpers) == (discs, front, rear)


def test_a_powerbot_reports_no_empty_slot(model_of: Callable[[str], RobotModel]) -> None:
    numbers = [disc.number for disc in model_of("powerbot").sonar]
    assert numbers == [*range(7), *range(8, 15), *range(16, 23), *range(24, 31)]


def test_values_are_in_si(model_of: Callable[[str], RobotModel], near: Callable[[object], Any]) -> None:
    model = model_of("powerbot")
    assert model.firmware is Family.AROS
    assert model.width == 0.68
    assert model.max_rotation == pytest.approx(2 * pi)
    assert model.scales.distance == pytest.approx(0.0005813)
    assert model.wheel_track == pytest.approx(2 / 0.00373 / 1000, abs=1e-6)
    assert model.vel2_unit == 0.02
    assert model.sonar[1] == near(SonarDisc(1, 0.2, 0.267, radians(65)))
    assert [disc.array for disc in model.sonar][::7] == [1, 2, 3, 4]
    assert model_of("amigo").scales.velocity == pytest.approx(0.0006154)
    assert model_of("p3dx-sh").ticks_per_metre == 132_000
    assert model_of("perfpb").irs[0] == InfraredSensor(0, 1, 2, 0.333, -0.233)
    assert model_of("amigo").lasers == ()
    assert model_of("patrolbot-sh").lasers[0] == LaserMount(
        "lms2xx",
        0.037,
        0.0,
        flipped=True,
        autoconnect=True,
        power_controlled=False,
        ignore=((radians(-76), radians(-72)), (radians(72), radians(76))),
    )


def test_a_model_starts_from_what_its_firmware_ships_with(model_of: Callable[[str], RobotModel]) -> None:
    assert model_of("p2dx").flash == FIRMWARES[Family.P2OS].flash
    assert not model_of("p2dx").flash.e_stall
    arcos = model_of("p3dx-sh").flash
    assert (arcos.watchdog, arcos.sip_cycle, arcos.sonar_cycle, arcos.bump_stall) == (2.0, 0.1, 0.04, 3)
    assert (arcos.rot_kp, arcos.rot_kv, arcos.rot_ki) == (30, 200, 0)
    assert (arcos.trans_kp, arcos.trans_kv, arcos.trans_ki) == (15, 450, 4)


def test_a_file_may_change_what_the_firmware_ships_with(table: dict[str, Any]) -> None:
    table["flash"] = {"sip_cycle_s": 0.05, "rotational_acceleration_deg_s2": 180, "rot_kp": 40, "e_stall": False}
    flash = RobotModel.from_table(table).flash
    assert (flash.sip_cycle, flash.rot_kp, flash.e_stall) == (0.05, 40, False)
    assert flash.rotational_acceleration == pytest.approx(pi)
    assert flash.watchdog == 2.0


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"colour": "red"}, "unknown key colour; did you mean"),
        ({"widht_m": 0.5}, "unknown key widht_m; did you mean width_m?"),
        ({"width_m": "wide"}, "width_m must be a number, not 'wide'"),
        ({"width_m": True}, "width_m must be a number, not True"),
        ({"front_bumpers": 5.5}, "front_bumpers must be a whole number, not 5.5"),
        ({"firmware": "ROS"}, "firmware must be one of P2OS, AROS, ARCOS, AmigOS, uARCS, not 'ROS'"),
        ({"sonar": [[0, 1, 2]]}, "sonar must hold rows of 4 numbers, not [0, 1, 2]"),
        ({"flash": {"watchdog_ms": 2000}}, "unknown key flash.watchdog_ms; did you mean flash.watchdog_s?"),
        ({"laser": [{"kind": "urg"}]}, "key laser.x_m is missing, it must be a number"),
        ({"laser": 5}, "laser must be a list of tables, not 5"),
        ({"laser": [5]}, "laser must be a list of tables, not [5]"),
        ({"flash": 5}, "flash must be a table, not 5"),
    ],
)
def test_a_table_with_an_error_is_refused_in_a_sentence(
    table: dict[str, Any], changes: dict[str, Any], message: str
) -> None:
    with pytest.raises(ValueError, match=f"^{re.escape(message)}"):
        RobotModel.from_table(table | changes)


SIZES = [
    "battery_nominal_v",
    "mass_kg",
    "radius_m",
    "width_m",
    "length_m",
    "length_front_m",
    "length_rear_m",
    "max_velocity_m_s",
    "max_rotation_deg_s",
    "wheel_track_m",
    "wheel_diameter_m",
    "ticks_per_m",
    "vel2_m_s_per_count",
    "distance_m_per_count",
    "velocity_m_s_per_count",
    "range_m_per_count",
]


@pytest.mark.parametrize("value", [0, -0.5, 1e-9, inf, nan])
@pytest.mark.parametrize("key", SIZES)
def test_a_size_that_no_robot_has_is_refused_with_its_key(table: dict[str, Any], key: str, value: float) -> None:
    with pytest.raises(
        ValueError, match=f"^{key} must be a number from 0.0001 to 1e\\+06, not {re.escape(str(value))}$"
    ):
        RobotModel.from_table(table | {key: value})


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"mass_kg": 10**400}, "mass_kg must be a number from 0.0001 to 1e+06, not 1000000"),
        ({"name": "x" * 20}, f"name must have 1 to 19 characters, none of them NUL, not '{'x' * 20}'"),
        ({"name": ""}, "name must have 1 to 19 characters, none of them NUL, not ''"),
        ({"robot_class": "Pioneer\0"}, "robot_class must have 1 to 19 characters, none of them NUL, not 'Pioneer"),
        ({"sonar": [[32, 0.1, 0.1, 0.0]]}, "sonar numbers must be from 0 to 31, not 32"),
        ({"sonar": [[-1, 0.1, 0.1, 0.0]]}, "sonar numbers must be from 0 to 31, not -1"),
        ({"sonar": [[1.5, 0.1, 0.1, 0.0]]}, "sonar numbers must be from 0 to 31, not 1.5"),
        ({"sonar": [[3, 0.1, 0.1, 0.0], [3, 0.2, 0.1, 0.0]]}, "sonar has the number 3 twice"),
        ({"sonar": [[inf, 0.1, 0.1, 0.0]]}, "sonar must hold rows of 4 numbers, not [inf, "),
        ({"ir": [[inf, 1, 2, 0.1, 0.1]]}, "ir must hold rows of 5 numbers, not [inf, "),
        ({"front_bumpers": 8}, "front_bumpers must be from 0 to 7, not 8"),
        ({"rear_bumpers": -1}, "rear_bumpers must be from 0 to 7, not -1"),
        ({"height_m": -1.0}, "height_m must be a number from 0 to 1e+06, not -1.0"),
    ],
)
def test_a_value_that_no_robot_has_is_refused_with_its_key(
    table: dict[str, Any], changes: dict[str, Any], message: str
) -> None:
    with pytest.raises(ValueError, match=f"^{re.escape(message)}"):
        RobotModel.from_table(table | changes)


def test_a_misspelt_key_is_told_from_a_missing_one(table: dict[str, Any]) -> None:
    table["widht_m"] = table.pop("width_m")
    with pytest.raises(ValueError, match="key width_m is missing, it must be a number; did you misspell it as widht_m"):
        RobotModel.from_table(table)

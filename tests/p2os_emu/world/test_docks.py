"""Docks: power for lowered contacts where a robot stands on one, and nowhere else."""

from collections.abc import Callable
from math import pi, radians

import pytest

from configs.loader import build
from geometry import Pose2D, parse_map
from p2os import Command, RobotModel, encode_command
from p2os.sip import ChargeState
from p2os_emu.emulator import STEP, Emulator
from p2os_emu.links.line import LinkProfile
from p2os_emu.links.memory import MemoryLink
from p2os_emu.world import World, WorldError, WorldSpec, load_world
from p2os_emu.world.aria_map import world_of
from p2os_emu.world.docks import Dock
from p2os_emu.world.world_file import WorldFile

DOCK = Dock("dock", Pose2D(2.0, 1.0, pi / 2))
LAB = WorldSpec("lab", docks=(DOCK,))


@pytest.mark.parametrize(
    ("along", "across", "turned", "reaches"),
    [
        (0.0, 0.0, 0.0, True),
        (0.045, -0.035, radians(-5.5), True),
        (0.055, 0.0, 0.0, False),
        (0.0, 0.045, 0.0, False),
        (0.0, 0.0, radians(6.5), False),
        (0.0, 0.0, pi, False),
    ],
)
def test_contacts_meet_the_plate_only_of_a_robot_that_stands_on_it(
    along: float, across: float, turned: float, reaches: bool
) -> None:
    x, y = DOCK.pose.transform(along, across)
    assert DOCK.reaches(Pose2D(x, y, DOCK.pose.heading + turned)) is reaches


def test_a_robot_on_a_dock_is_charged_while_its_contacts_are_down_and_until_it_is_moved(
    make_world: Callable[..., World], model: Callable[[str], RobotModel]
) -> None:
    emulator = Emulator(make_world(LAB), LinkProfile("ideal"))
    robot = emulator.add("happy", model("peoplebot-sh"), MemoryLink(), pose=DOCK.pose)
    battery = robot.microcontroller.board.battery

    def charges_after(seconds: float) -> bool:
        for _ in range(round(seconds / STEP)):
            emulator.step()
        return battery.charging is not ChargeState.NOT_CHARGING

    assert not charges_after(1.0)
    for frame in ("FA FB 03 00 00 00", "FA FB 03 01 00 01", "FA FB 03 02 00 02"):
        robot.microcontroller.receive(bytes.fromhex(frame))
    robot.microcontroller.receive(encode_command(Command.OPEN))
    robot.microcontroller.receive(encode_command(Command.CHARGE, 1))
    assert charges_after(6.0)
    emulator.place("happy", Pose2D(0.0, 0.0, 0.0))
    assert not charges_after(0.5)


def test_the_docks_of_a_world_file_have_a_station_in_front_of_the_robot() -> None:
    entry = {"at_m": [1.0, 2.0], "heading_deg": 180.0, "name": "charger"}
    spec = build(WorldFile, {"docks": [entry]}, "test").to_spec("test", "test")
    assert spec.docks == (Dock("charger", Pose2D(1.0, 2.0, pi)),)
    (station,) = spec.furniture
    assert station.name == "charger"
    assert station.contains(1.0 - 0.46, 2.0)
    assert not station.contains(1.0 - 0.44, 2.0)


def test_docks_that_make_no_sense_are_refused_with_their_place_in_the_file() -> None:
    with pytest.raises(WorldError, match=r"test: docks\[0\] dock: station_m must be above 0 m, not -1"):
        build(WorldFile, {"docks": [{"at_m": [0, 0], "station_m": -1.0}]}, "test").to_spec("test", "test")


def test_docks_of_an_aria_map_charge_too() -> None:
    text = '2D-Map\nCairn: Dock 1000 2000 90 "" ICON "Charger" \nLINES\n0 0 5000 0\nDATA\n'
    (dock,) = world_of(parse_map(text, "lab.map"), "lab").docks
    assert (dock.name, dock.pose.x, dock.pose.y) == ("Charger", 1.0, 2.0)
    assert dock.pose.heading == pytest.approx(pi / 2)


@pytest.mark.parametrize("name", ["office", "house"])
def test_shipped_worlds_with_rooms_have_a_dock_on_which_a_powerbot_fits(
    name: str, make_world: Callable[..., World], model: Callable[[str], RobotModel]
) -> None:
    spec = load_world(name)
    (dock,) = spec.docks
    body = make_world(spec).add_robot("happy", model("powerbot"), dock.pose)
    body.refresh()
    assert body.is_docked
    assert not body.touched

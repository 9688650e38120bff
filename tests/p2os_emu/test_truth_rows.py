"""What the truth of the control socket reports of accessories."""

import json
from collections.abc import Iterator
from math import pi, radians
from typing import Any

import pytest

import configs
from geometry import Pose2D
from p2os import Command, RobotModel, encode_command
from p2os.accessories.lms import LmsMode, LmsRequestCode
from p2os.accessories.lms_framing import encode
from p2os_emu.accessories.lms200 import ScannerModel
from p2os_emu.emulator import STEP, EmulatedRobot, Emulator
from p2os_emu.fit import read_fit
from p2os_emu.fitting import plugged_head
from p2os_emu.gripper_model import GripperModel
from p2os_emu.links.line import LinkProfile
from p2os_emu.links.memory import MemoryLink
from p2os_emu.truth_rows import robot_row
from p2os_emu.world import World, WorldSpec
from p2os_emu.world.movable import Movable, Shape

ACCESSORIES = {"gripper", "arm", "camera_head", "laser"}


class Rig:
    """One robot with accessories, on lines in memory."""

    def __init__(self, world: World, model: str, *parts: str) -> None:
        robot_model, fit = read_fit(parts, configs.load(RobotModel, "robots", model))
        self.emulator = Emulator(world, LinkProfile("ideal"))
        self.line = MemoryLink()
        self.cables = {part: MemoryLink() for part in fit.cables}
        self.robot: EmulatedRobot = self.emulator.add("happy", robot_model, self.line, fit=fit, cables=self.cables)

    def tell(self, command: Command, value: Any = None) -> None:
        self.line.client_write(encode_command(command, value))
        self.run(STEP)

    def connect(self) -> None:
        for command in (Command.SYNC0, Command.SYNC1, Command.SYNC2, Command.OPEN):
            self.tell(command)

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds / STEP)):
            self.emulator.step()

    def row(self) -> dict[str, Any]:
        row = robot_row(self.emulator, self.robot)
        json.dumps(row, allow_nan=False)
        return row


@pytest.fixture
def world() -> Iterator[World]:
    with World(WorldSpec("empty")) as world:
        yield world


def test_accessories_that_are_not_fitted_are_null(world: World) -> None:
    row = Rig(world, "p3dx-sh").row()
    assert {name for name in ACCESSORIES if row[name] is None} == ACCESSORIES


def test_a_gripper_reports_metres_and_what_it_holds(world: World) -> None:
    rig = Rig(world, "p3dx-sh", "gripper")
    assert rig.row()["gripper"]["held"] is None
    opened = rig.row()["gripper"]["opening"]
    assert opened == pytest.approx(configs.load(GripperModel, "accessories", "gripper-pioneer").opening_m)
    rig.connect()
    rig.tell(Command.GRIPPER, 2)
    rig.run(0.5)
    closing = rig.row()["gripper"]
    assert 0.0 < closing["opening"] < opened
    assert closing["opening_speed"] < 0.0


@pytest.mark.parametrize(("model", "joints"), [("p3dx-sh", 5), ("powerbot", 7)])
def test_an_arm_reports_its_joints_in_radians_and_its_fingers_in_metres(world: World, model: str, joints: int) -> None:
    rig = Rig(world, model, "arm")
    arm = rig.robot.body.arm
    assert arm is not None
    arm.move(0, 0.5, 1.0)
    rig.run(0.2)
    row = rig.row()["arm"]
    assert len(row["joints"]) == len(row["speeds"]) == joints
    assert row["joints"] == pytest.approx(list(arm.positions)[:-1])
    assert 0.05 < row["joints"][0] < 0.5
    assert row["speeds"][0] > 0.1
    assert row["opening"] == pytest.approx(arm.positions[-1])
    assert row["held"] is None


def test_an_arm_reports_what_it_holds() -> None:
    post = Movable("post", Shape.CYLINDER, Pose2D(2.53), 0.045, 0.045, 0.38, 0.4, 0.5, "red")
    with World(WorldSpec("hand", objects=(post,))) as world:
        rig = Rig(world, "powerbot-sh", "arm")
        arm = rig.robot.body.arm
        assert arm is not None
        world.place("happy", Pose2D())
        for joint, angle in enumerate((0, 100, 0, 60, 0, 20, 90)):
            arm.move(joint, radians(angle), 1.0)
        arm.move(7, 0.07, 0.08)
        rig.run(4.0)
        world.place("happy", Pose2D(2.0))
        arm.move(7, 0.03, 0.08)
        rig.run(1.0)
        assert rig.row()["arm"]["held"] == "post"
        assert rig.row()["gripper"] is None


def test_an_arm_has_power_when_it_is_told_so(world: World) -> None:
    rig = Rig(world, "p3dx-sh", "arm")
    rig.connect()
    assert rig.row()["arm"]["powered"] is False
    rig.tell(Command.ARM_POWER, 1)
    assert rig.row()["arm"]["powered"] is True
    rig.robot.power_off()
    assert rig.row()["arm"]["powered"] is False


@pytest.mark.parametrize("head", ["vcc4", "evid30"])
def test_a_camera_head_reports_where_it_truly_looks(world: World, head: str) -> None:
    rig = Rig(world, "p3dx-sh", f"ptz:{head}")
    device = plugged_head(rig.robot.microcontroller)
    assert device is not None
    device.is_on = True
    wide = rig.row()["camera_head"]
    assert (wide["pan"], wide["tilt"], wide["zoom"], wide["moving"]) == (0.0, 0.0, 1.0, False)
    device.head.pan.go(radians(30))
    device.head.lens.go(device.head.model.lens.counts)
    rig.run(STEP)
    assert rig.row()["camera_head"]["moving"] is True
    rig.run(10.0)
    row = rig.row()["camera_head"]
    assert (row["pan"], row["moving"], row["powered"]) == (pytest.approx(radians(30)), False, True)
    assert row["zoom"] > 5.0
    assert row["field_of_view"] < wide["field_of_view"] / 4
    device.is_on = False
    assert rig.row()["camera_head"]["powered"] is False


def test_a_laser_reports_where_it_sits_and_whether_it_scans(world: World) -> None:
    rig = Rig(world, "powerbot", "laser")
    mount = rig.robot.model.laser
    rig.run(configs.load(ScannerModel, "accessories", "lms200").boot_s + 0.5)
    row = rig.row()["laser"]
    assert (row["x"], row["y"], row["heading"], row["flipped"]) == (mount.x, mount.y, mount.heading, mount.flipped)
    assert (row["field_of_view"], row["resolution"], row["beams"]) == (pytest.approx(pi), radians(1.0), 181)
    assert (row["powered"], row["scanning"], row["baud"]) == (True, False, 9600)
    rig.cables["laser"].client_write(encode(LmsRequestCode.MODE, bytes([LmsMode.CONTINUOUS])))
    rig.run(0.2)
    assert rig.row()["laser"]["scanning"] is True
    rig.robot.power_off()
    assert (rig.row()["laser"]["powered"], rig.row()["laser"]["scanning"]) == (False, False)

"""Accessories from the firmware to the bus, in virtual time."""

from collections.abc import Callable
from math import inf
from random import Random
from typing import TYPE_CHECKING

import numpy as np
import pytest

from bus import keys
from configs import load
from gateway.settings import Calibration, Fitted, Settings
from p2os import Command, RobotModel
from p2os_emu.fit import read_fit
from p2os_emu.fitting import FittingContext, plug_in
from p2os_emu.microcontroller import Microcontroller
from p2os_emu.microcontroller.panel import Stick
from tests.gateway.test_robot_on_bus import Office
from tests.p2os_emu.microcontroller.bench import PlainGripper

if TYPE_CHECKING:
    from tests.gateway.conftest import MakeBench

MODEL = load(RobotModel, "robots", "p3dx-sh")
MakeFitted = Callable[..., Office]


@pytest.fixture
def make_fitted(make_bench: "MakeBench") -> MakeFitted:
    """An office whose robot is fitted with parts, as `--fit` names them."""

    def make(*parts: str, model: str = "p3dx-sh", settings: Settings | None = None) -> Office:
        bench = make_bench(model, settings=settings)
        fitted, fit = read_fit(parts, load(RobotModel, "robots", model))
        bench.robot = Microcontroller(fitted, "happy", fit=fit)
        if fit.has("gripper"):
            bench.body.gripper = PlainGripper()
        for part in fit.parts:
            plug_in(part, FittingContext(fitted, fit, bench.robot, bench.body, Random(3)))
        return Office(bench, settings or Settings())

    return make


def elements(office: Office) -> dict[str, dict[str, object]]:
    return {element["name"]: element for element in office.ask("description")["elements"]}


def test_bare_robot_describes_and_publishes_no_accessory(make_fitted: MakeFitted) -> None:
    office = make_fitted()
    office.run(5.0)
    assert elements(office).keys() == {"base", "battery", "io", "sonar", "sound", "servos"}
    for topic in (keys.GRIPPER, keys.IMU, keys.COMPASS, keys.JOYSTICK, keys.IR, keys.PTZ, keys.ARM):
        assert f"happy/{topic.suffix}" not in office.heard
    assert "has no gripper" in office.refusal("command/gripper", do="open")


def test_gyro_tells_the_turn_rate_and_its_bias_is_learned_at_rest(make_fitted: MakeFitted) -> None:
    office = make_fitted("gyro:analog")
    office.run(10.0)
    imu = office.last("imu")
    assert imu.header.frame_id == "happy/base_link"
    assert imu.angular_velocity.z == pytest.approx(0.0, abs=0.05)
    assert imu.orientation_covariance[0] == imu.linear_acceleration_covariance[0] == -1.0
    assert 0.0 < imu.angular_velocity_covariance[8] < 0.01
    office.bench.body.turn_rate = 0.5
    office.drive(0.1)
    office.run(0.3, lambda: office.drive(0.1, 0.5))
    assert office.last("imu").angular_velocity.z == pytest.approx(0.5, abs=0.1)
    assert "gyro" in elements(office)


def test_gyro_inside_the_controller_is_described_and_sends_nothing(make_fitted: MakeFitted) -> None:
    office = make_fitted("gyro:controller")
    office.run(3.0)
    assert elements(office)["gyro"]["streams"] == []
    assert "controller" in str(elements(office)["gyro"]["used_by"])
    assert "happy/imu" not in office.heard


def test_compass_is_found_and_streams(make_fitted: MakeFitted) -> None:
    office = make_fitted("compass")
    office.run(3.0)
    compass = office.last("compass")
    assert compass.header.frame_id == "happy/base_link"
    field = compass.magnetic_field
    assert 1e-6 < np.hypot(field.x, field.y) < 1e-4
    assert len(office.heard["happy/compass"]) > 5
    assert "compass" in elements(office)


def test_joystick_shows_itself_when_a_hand_moves_it_and_may_drive(make_fitted: MakeFitted) -> None:
    office = make_fitted("joystick")
    office.run(3.0)
    assert "joystick" not in elements(office)
    office.bench.robot.panel.joystick = Stick(x=-0.5, y=0.75)
    office.run(3.0)
    joy = office.last("joystick")
    assert joy.axes[0] == pytest.approx(0.5, abs=0.01)  # to the left, as ROS counts
    assert joy.axes[1] == pytest.approx(0.75, abs=0.01)
    before = office.bench.now
    office.ask("command/joystick", on=True)
    office.run(2.0)
    said = office.bench.commands(since=before)
    assert Command.JOYDRIVE in said
    assert Command.STOP not in said[said.index(Command.JOYDRIVE) :]  # nobody holds it back


def test_a_joystick_drives_no_more_when_its_lease_ends_although_a_frame_is_lost(make_fitted: MakeFitted) -> None:
    office = make_fitted("joystick")
    office.run(3.0)
    token = office.ask("lease", do="take", holder="me", seconds=20.0)["token"]
    office.bench.robot.panel.joystick = Stick(x=0.0, y=0.75, throttle=1.0, button1=True)
    office.run(3.0)
    office.ask("command/joystick", on=True, token=token)
    office.run(2.0)
    assert office.bench.body.is_turning()
    office.bench.deaf = True
    office.ask("lease", do="release", token=token)
    office.run(0.05)
    office.bench.deaf = False
    office.run(3.0)
    assert not office.bench.body.is_turning()


def test_gripper_moves_as_it_is_told_and_only_for_the_holder_of_the_lease(make_fitted: MakeFitted) -> None:
    office = make_fitted("gripper")
    office.run(1.0)
    assert office.last("gripper").fitted
    token = office.ask("lease", do="take", holder="me")["token"]
    assert "lease" in office.refusal("command/gripper", do="open")
    assert office.ask("command/gripper", do="open", token=token)["accepted"]
    office.run(0.3)
    told = [each.value for _, each in office.bench.sent if each.command is Command.GRIPPER]
    assert told == [15, 1]  # what somebody set going before ends with a new lease
    assert "open, close" in office.refusal("command/gripper", do="fly", token=token)
    office.run(4.0)
    assert office.last("gripper").paddles_open
    joints = office.last("joint_states")
    assert dict(zip(joints.name, joints.position.tolist(), strict=True)) == {
        "happy/left_paddle": pytest.approx(0.1),
        "happy/right_paddle": pytest.approx(-0.1),
    }


@pytest.mark.parametrize(("command", "given"), [("stop", {}), ("estop", {"on": True})])
def test_who_stops_the_robot_stops_its_gripper(make_fitted: MakeFitted, command: str, given: dict[str, bool]) -> None:
    office = make_fitted("gripper")
    office.run(1.0)
    office.ask("command/gripper", do="up")
    office.run(0.2)
    assert office.last("gripper").lift_moving
    office.ask(f"command/{command}", **given)
    office.run(0.5)
    assert not office.last("gripper").lift_moving
    assert not office.last("gripper").lift_up


def test_gripper_stops_when_the_lease_on_it_ends_and_the_wheels_go_on(make_fitted: MakeFitted) -> None:
    office = make_fitted("gripper")
    office.run(1.0)
    token = office.ask("lease", do="take", holder="me", element="gripper", seconds=0.4)["token"]
    office.ask("command/gripper", do="up", token=token)
    office.run(0.3, lambda: office.drive(0.3))
    assert office.last("gripper").lift_moving
    office.run(0.7, lambda: office.drive(0.3))
    assert not office.last("gripper").lift_moving
    assert not office.last("gripper").lift_up
    assert office.bench.body.is_turning()


def test_camera_head_stops_when_the_lease_on_it_ends(make_fitted: MakeFitted) -> None:
    office = make_fitted("ptz:evid30")
    office.run(5.0)
    token = office.ask("lease", do="take", holder="me", element="ptz", seconds=0.5)["token"]
    assert "me holds the lease on the ptz" in office.refusal("command/ptz", pan=1.0)
    office.ask("command/ptz", pan=1.5, token=token)
    office.run(4.0)
    assert 0.1 < office.last("ptz").pan < 1.0
    assert not office.last("ptz").moving


def test_joystick_drives_no_longer_when_somebody_takes_the_base(make_fitted: MakeFitted) -> None:
    office = make_fitted("joystick", settings=Settings(fitted=Fitted(joystick=True)))
    office.run(3.0)
    office.ask("command/joystick", on=True)
    office.run(0.5)
    office.ask("lease", do="take", holder="me", element="base")
    office.run(0.2)
    told = [each.value for _, each in office.bench.sent if each.command is Command.JOYDRIVE]
    assert told == [1, 0]
    assert "me holds the lease on the base" in office.refusal("command/joystick", on=True)


def test_gripper_obeys_a_latched_estop_only_to_stop(make_fitted: MakeFitted) -> None:
    office = make_fitted("gripper")
    office.run(1.0)
    office.ask("command/estop", on=True)
    assert "e-stop" in office.refusal("command/gripper", do="open")
    assert "e-stop" in office.refusal("command/servo", port=1, pulse=0.001)
    assert office.ask("command/servo", port=1, pulse=0.0)["accepted"]
    assert office.ask("command/gripper", do="stop")["accepted"]


def test_infrared_sensors_are_switches(make_fitted: MakeFitted) -> None:
    office = make_fitted(model="peoplebot-sh")
    office.bench.body.infrared = 0xFF & ~0b0010
    office.run(1.0)
    ir = {each.header.frame_id: each for each in office.last("ir").ranges}
    assert {name: each.range for name, each in ir.items()} == {
        "happy/ir_0": inf,
        "happy/ir_1": -inf,
        "happy/ir_2": inf,
        "happy/ir_3": inf,
    }
    assert {each.min_range == each.max_range for each in ir.values()} == {True}
    assert {each.radiation_type for each in ir.values()} == {1}  # INFRARED
    frames = {each.child_frame_id for each in office.last("tf_static").transforms}
    assert ir.keys() <= frames


@pytest.mark.parametrize(
    ("suffix", "arguments", "command", "value"),
    [
        ("sound", {"notes": [[60, 0.2]]}, Command.SAY, bytes([10, 60])),
        ("sound", {"on": False}, Command.SOUNDTOG, 0),
        ("servo", {"port": 1, "pulse": 0.0015}, Command.PTUPOS, (1, 150)),
        ("lcd", {"text": "hi"}, Command.LCDWRITE, b"hi\0"),
        ("power", {"output": "laser", "on": True}, Command.SETPBIOPORT, (11, 1)),
        ("charge", {"on": True}, Command.CHARGE, 1),
    ],
)
def test_panel_commands_reach_the_robot(
    make_fitted: MakeFitted, suffix: str, arguments: dict[str, object], command: Command, value: object
) -> None:
    office = make_fitted(model="powerbot-sh", settings=Settings(fitted=Fitted(lcd=True)))
    office.run(1.0)
    answer = office.ask(f"command/{suffix}", **arguments)
    assert answer["accepted"]
    assert "outputs" in answer or suffix != "power"
    office.run(0.2)
    assert [each.value for _, each in office.bench.sent if each.command is command] == [value]


def test_sound_wants_exactly_one_of_its_arguments(make_fitted: MakeFitted) -> None:
    office = make_fitted()
    assert "one of notes, number and on" in office.refusal("command/sound")
    assert "one of notes, number and on" in office.refusal("command/sound", number=1, on=True)
    assert "no numbered sounds" in office.refusal("command/sound", number=1)


def test_amigobot_lists_its_sounds(make_fitted: MakeFitted) -> None:
    office = make_fitted(model="amigo")
    office.run(3.0)
    assert "sounds" in elements(office)["sound"]


def test_odometry_with_the_gyro_is_not_led_astray_by_slipping_wheels(make_fitted: MakeFitted) -> None:
    """The floor is so slippery that the robot turns half as far as its wheels say."""

    def heading_after_a_turn(settings: Settings) -> float:
        office = make_fitted("gyro:analog", settings=settings)
        office.run(6.0)
        body = office.bench.body

        def turn() -> None:
            office.drive(0.0, 0.5)
            body.turn_rate = (body.right.velocity - body.left.velocity) / MODEL.wheel_track / 2.0

        office.run(2.0, turn)
        return office.bench.driver.odometry.turned

    by_wheels = heading_after_a_turn(Settings())
    by_gyro = heading_after_a_turn(Settings(use_gyro=True, calibration=Calibration()))
    assert by_wheels > 0.6
    assert by_gyro == pytest.approx(by_wheels / 2.0, rel=0.15)

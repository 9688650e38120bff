"""Devices for the parts of a fit: on cables of their own, or behind the robot's AUX ports."""

from collections.abc import Callable, Mapping
from random import Random
from typing import NamedTuple

from configs import load
from p2os import RobotModel
from p2os.accessories.arm_model import ArmModel
from p2os.accessories.head_model import HEAD_PORT, HeadModel
from p2os_emu.accessories.analog_gyro import AnalogGyro, AnalogGyroSpec
from p2os_emu.accessories.evid30 import EviD30
from p2os_emu.accessories.lms200 import Lms200, ScannerModel
from p2os_emu.accessories.powercube import PowerCubeArm
from p2os_emu.accessories.tcm2 import Tcm2, Tcm2Spec
from p2os_emu.accessories.vcc4 import Vcc4
from p2os_emu.body import Body
from p2os_emu.device import CableDevice
from p2os_emu.fit import Fit, FitError
from p2os_emu.gripper_model import gripper_of
from p2os_emu.microcontroller import Microcontroller
from p2os_emu.microcontroller.compass import CompassServer
from p2os_emu.microcontroller.gyro import GyroServer

LASER_POWER = "lrf"
"""The board's power output that feeds a laser whose model says that it can be switched."""


class FittingContext(NamedTuple):
    """Everything that a device may need to connect to.

    rng: of this device alone, seeded.
    """

    model: RobotModel
    fit: Fit
    microcontroller: Microcontroller
    body: Body
    rng: Random


def _powercube(bench: FittingContext) -> CableDevice:
    if bench.body.arm is None:
        raise FitError("this world has no joints, and so no arm; take one with physics")
    return PowerCubeArm(load(ArmModel, "accessories", "powercube-arm"), bench.body.arm)


def _laser(bench: FittingContext) -> CableDevice:
    def has_power() -> bool:
        return not mount.power_controlled or bench.microcontroller.board.outputs.power[LASER_POWER]

    mount = bench.model.laser
    return Lms200(load(ScannerModel, "accessories", "lms200"), mount, bench.body, has_power)


CABLED: Mapping[tuple[str, str], Callable[[FittingContext], CableDevice]] = {
    ("laser", "lms200"): _laser,
    ("arm", "powercube"): _powercube,
}
"""Part and variant to what makes the device on its own cable."""


def _wire_gripper(bench: FittingContext) -> None:
    gripper = gripper_of(bench.fit)
    if gripper is not None:
        bench.microcontroller.board.gripper.fit(gripper)


def _fit_gyro(bench: FittingContext, inside: bool) -> None:
    spec = load(AnalogGyroSpec, "accessories", "analog-gyro")
    bench.microcontroller.board.gyro = GyroServer(AnalogGyro(spec, bench.rng), inside)


def _fit_compass(bench: FittingContext) -> None:
    bench.microcontroller.board.compass = CompassServer(Tcm2(load(Tcm2Spec, "accessories", "tcm2"), bench.rng))


def _head_model(bench: FittingContext) -> HeadModel:
    return load(HeadModel, "accessories", bench.fit.parts["ptz"])


PLUGGED: Mapping[tuple[str, str], Callable[[FittingContext], None]] = {
    ("gyro", "analog"): lambda bench: _fit_gyro(bench, inside=False),
    ("gyro", "controller"): lambda bench: _fit_gyro(bench, inside=True),
    ("compass", "tcm2"): _fit_compass,
    ("ptz", "vcc4"): lambda bench: bench.microcontroller.board.plug(HEAD_PORT, lambda: Vcc4(_head_model(bench))),
    ("ptz", "evid30"): lambda bench: bench.microcontroller.board.plug(HEAD_PORT, lambda: EviD30(_head_model(bench))),
    ("gripper", "pioneer"): _wire_gripper,
    ("gripper", "peoplebot"): _wire_gripper,
    ("arm", "pioneer"): lambda bench: bench.microcontroller.board.arm.fit(load(ArmModel, "accessories", "pioneer-arm")),
}
"""Part and variant to what plugs the device into the microcontroller."""


def plugged_head(controller: Microcontroller) -> Vcc4 | EviD30 | None:
    """Return the camera head behind a robot's AUX port, None where there is none."""
    device = controller.board.aux[HEAD_PORT].device
    return device if isinstance(device, Vcc4 | EviD30) else None


def cabled(part: str, bench: FittingContext) -> CableDevice:
    """Make the device of a part that has a cable of its own."""
    return CABLED[part, bench.fit.parts[part]](bench)


def plug_in(part: str, bench: FittingContext) -> None:
    """Connect a part to the microcontroller, if it belongs there."""
    plug = PLUGGED.get((part, bench.fit.parts[part]))
    if plug is not None:
        plug(bench)

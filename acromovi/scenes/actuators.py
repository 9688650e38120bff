"""Scenes of actuators: gripper, arms, sounds, display, charger."""

import math
from typing import Any

from acromovi.scenes.stage import MOST_MOTIONS, Scene, SceneFailed, SceneStage
from bus import keys

BOX = "red box"


def _gripper(stage: SceneStage) -> None:
    stage.wait_for_element("gripper")
    stage.tell(keys.GRIP, do="open")
    stage.tell(keys.GRIP, do="down")
    stage.see(keys.GRIPPER, lambda gripper: gripper.paddles_open and gripper.lift_down, "an open gripper, lift down")
    stage.tell(keys.MOVE, distance=1.2)  # more than it takes: the beams say when to stop
    gripper = stage.see(keys.GRIPPER, lambda gripper: gripper.inner_beam, "a broken inner beam", 15.0)
    stage.say(f"something stands between the paddles: beams {gripper.outer_beam}, {gripper.inner_beam}")
    stage.tell(keys.STOP)
    stage.tell(keys.GRIP, do="close")
    stage.see(keys.GRIPPER, lambda gripper: gripper.left_contact and gripper.right_contact, "both contacts")
    stage.tell(keys.GRIP, do="up")
    stage.see(keys.GRIPPER, lambda gripper: gripper.lift_up, "the lift up", 15.0)
    before = _box(stage)
    stage.say(f"it holds the {BOX}, {before[2] * 100:.0f} cm above the floor")
    stage.drive(-0.2, 0.0, 2.5)
    stage.tell(keys.GRIP, do="down")
    stage.see(keys.GRIPPER, lambda gripper: gripper.lift_down, "the lift down", 15.0)
    stage.tell(keys.GRIP, do="open")
    stage.see(keys.GRIPPER, lambda gripper: gripper.paddles_open, "open paddles")
    after = _box(stage)
    moved = math.dist(before[:2], after[:2])
    if moved < 0.2:
        raise SceneFailed(f"the {BOX} came only {moved:.2f} m along")
    stage.say(f"it put the {BOX} down {moved:.2f} m from where it took it")


def _box(stage: SceneStage) -> tuple[float, float, float]:
    x, y, z, *_ = stage.ask("truth")["objects"][BOX]
    return x, y, z


def _arm(stage: SceneStage) -> None:
    stage.wait_for_element("arm")
    stage.tell(keys.REACH, do="power", on=True)
    stage.see(keys.ARM, lambda arm: arm.powered, "an arm with power", 15.0)
    stage.tell(keys.REACH, do="home")
    stage.see(keys.ARM, lambda arm: arm.homed and not any(arm.moving), "an arm at home", 30.0)
    refusal = stage.is_refused(keys.REACH, do="move", joints={"1": 9.0})
    stage.say(f"out of reach: {refusal}")
    _move_joints(stage, {"1": 0.5, "2": 0.4})
    stage.tell(keys.REACH, do="park")


def _move_joints(stage: SceneStage, wanted: dict[str, float]) -> None:
    """Move joints and see them arrive; again where a gateway that a busy machine froze has stopped them."""
    names = {f"{stage.robot}/arm_joint_{joint}": angle for joint, angle in wanted.items()}

    def is_there(joints: Any) -> bool:
        angles = dict(zip(joints.name, joints.position, strict=True))
        return all(name in angles and abs(angles[name] - angle) < 0.05 for name, angle in names.items())

    for tries_left in reversed(range(MOST_MOTIONS)):
        stage.tell(keys.REACH, do="move", joints=wanted)
        try:
            joints = stage.see(keys.JOINT_STATES, is_there, f"joints at {wanted}", 10.0)
            break
        except SceneFailed:
            if not tries_left:
                raise
    stage.say(", ".join(f"{name} {angle:+.3f}" for name, angle in zip(joints.name, joints.position, strict=True)))


def _sound(stage: SceneStage) -> None:
    stage.tell(keys.SOUND, notes=[[60, 0.1], [64, 0.1], [67, 0.2]])
    stage.wait(lambda: len(stage.truth()["notes"]) >= 3, "three notes on the buzzer")
    stage.say(f"the buzzer played {stage.truth()['notes']}")


def _servo(stage: SceneStage) -> None:
    stage.tell(keys.SERVO, port=1, pulse=0.0015)
    stage.wait(lambda: bool(stage.truth()["servos"]), "a pulse on a servo port")
    stage.say(f"servo pulses: {stage.truth()['servos']}")


def _outputs(stage: SceneStage) -> None:
    stage.tell(keys.OUTPUT, mask=5, value=4)
    ports = stage.see(keys.IO, lambda ports: bool(ports.digital_out[2]), "an output that is on")
    stage.say(f"outputs {[int(pin) for pin in ports.digital_out]}, inputs {[int(pin) for pin in ports.digital_in]}")


def _charger(stage: SceneStage) -> None:
    stage.wait_for_element("charger")
    stage.ask("fault", fault="charger-plugged@0+20")
    stage.tell(keys.CHARGE, on=True)
    battery = stage.see(keys.BATTERY, lambda battery: battery.power_supply_status == 1, "a charging battery")
    stage.say(f"the battery charges at {battery.voltage:.1f} V")
    stage.tell(keys.CHARGE, on=False)


SCENES = (
    Scene(
        "gripper",
        "a Pioneer picks up a box, carries it and puts it down",
        "--robot p3dx-sh:{name} --fit gripper --world gripper-lab",
        _gripper,
    ),
    Scene("arm", "the Pioneer's 5-DOF arm: power, limits, two joints", "--robot p3dx-sh:{name} --fit arm", _arm),
    Scene(
        "powercube",
        "the PowerBot's 7-DOF arm on its own port",
        "--robot powerbot:{name} --fit arm",
        _arm,
        "--arm {arm_port}",
    ),
    Scene("sound", "notes on the buzzer", "--robot p3dx-sh:{name}", _sound),
    Scene("servo", "the pulse of an RC servo", "--robot p3dx-sh:{name}", _servo),
    Scene("outputs", "digital outputs and inputs", "--robot p3dx-sh:{name}", _outputs),
    Scene("charger", "the charging contacts of a PowerBot", "--robot powerbot-sh:{name}", _charger),
)

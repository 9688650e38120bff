"""Rows of the true state for the control socket: robots, objects, people and doors. SI and radians."""

from typing import Any

from p2os_emu.accessories.lms200 import Lms200
from p2os_emu.body import ArmMechanism
from p2os_emu.emulator import EmulatedRobot, Emulator
from p2os_emu.fitting import plugged_head
from p2os_emu.gripper_model import gripper_of
from p2os_emu.microcontroller import Microcontroller
from p2os_emu.target_model import target_of, target_on

LAST_TOUCHES = 10
"""Of a robot, in one answer; the count has them all."""


def robot_row(emulator: Emulator, robot: EmulatedRobot) -> dict[str, Any]:
    """Return how one robot is: its truth, its board, its line and its accessories; null for those not fitted."""
    truth = emulator.world.truth(robot.name)
    touches = emulator.world.touches(robot.name)
    return {
        "x": truth.pose.x,
        "y": truth.pose.y,
        "heading": truth.pose.heading,
        "linear": truth.linear,
        "angular": truth.angular,
        "placed": emulator.world.placed(robot.name),
        "model": robot.model.name,
        "port": robot.line.link.port,
        "connected": robot.microcontroller.connected,
        "motors_enabled": robot.microcontroller.board.motors.enabled,
        "battery_charge": robot.microcontroller.board.battery.charge,
        "frames_dropped": robot.line.link.dropped,
        "touches": touches.count,
        "touched": [{"time": time, "what": what} for time, what in touches.last[-LAST_TOUCHES:]],
        **_shown(robot.microcontroller),
        "gripper": _gripper(emulator, robot),
        "arm": _arm(emulator, robot),
        "camera_head": _camera_head(robot),
        "laser": _laser(robot),
        "target": _target(robot),
    }


def _gripper(emulator: Emulator, robot: EmulatedRobot) -> dict[str, Any] | None:
    """Return opening between the paddles and height of the lift, m; held: name of the object."""
    gripper, model = robot.body.gripper, gripper_of(robot.fit)
    if gripper is None or model is None:
        return None
    state = gripper.state
    return {
        "opening": state.opening * model.opening_m,
        "lift": state.lift * model.lift_travel_m,
        "opening_speed": state.opening_speed * model.opening_m,
        "lift_speed": state.lift_speed * model.lift_travel_m,
        "outer_beam": state.outer_beam,
        "inner_beam": state.inner_beam,
        "left_contact": state.left_contact,
        "right_contact": state.right_contact,
        "held": emulator.world.held(robot.name) if state.holds else None,
    }


def _arm(emulator: Emulator, robot: EmulatedRobot) -> dict[str, Any] | None:
    """Return the joints from the robot outwards, rad and rad/s, and the opening between the fingers, m and m/s.

    held: name of the object between the fingers.
    """
    arm: ArmMechanism | None = robot.body.arm
    if arm is None:
        return None
    *joints, opening = arm.positions
    *speeds, opening_speed = arm.velocities
    cable = robot.cables.get("arm")
    has_power = robot.microcontroller.board.arm.is_powered if cable is None else cable.is_powered
    return {
        "joints": joints,
        "speeds": speeds,
        "opening": opening,
        "opening_speed": opening_speed,
        "powered": robot.is_powered and has_power,
        "held": emulator.world.held(robot.name) if arm.holds else None,
    }


def _camera_head(robot: EmulatedRobot) -> dict[str, Any] | None:
    """Return pan to the left, tilt upwards and horizontal field of view, rad; zoom: magnification."""
    device = plugged_head(robot.microcontroller)
    if device is None:
        return None
    head = device.head
    return {
        "pan": head.pan.position,
        "tilt": head.tilt.position,
        "zoom": head.zoom,
        "field_of_view": head.field_of_view,
        "moving": head.is_turning or head.lens.is_moving,
        "powered": robot.is_powered and device.is_on,
    }


def _laser(robot: EmulatedRobot) -> dict[str, Any] | None:
    """Return where the scanner sits on the robot, m and rad, and how it scans; dirt: of its window, 0 to 1."""
    cable = robot.cables.get("laser")
    if cable is None or not isinstance(cable.device, Lms200):
        return None
    laser = cable.device
    mount, beams = laser.mount, laser.variant
    has_power = robot.is_powered and cable.is_powered and laser.is_powered
    return {
        "x": mount.x,
        "y": mount.y,
        "height": laser.height,
        "heading": mount.heading,
        "flipped": mount.flipped,
        "field_of_view": -2.0 * beams.first_bearing,
        "resolution": beams.resolution,
        "beams": beams.beams,
        "baud": laser.baud,
        "dirt": laser.dirt,
        "powered": has_power,
        "scanning": has_power and laser.is_scanning,
    }


def _target(robot: EmulatedRobot) -> dict[str, Any] | None:
    """Return where the middle between the flanks of the target is on the robot, m, and its heading, rad."""
    target = target_of(robot.fit)
    if target is None:
        return None
    place = target_on(robot.model, target)
    return {"x": place.x, "y": place.y, "height": target.middle_m, "heading": place.heading}


def _shown(controller: Microcontroller) -> dict[str, Any]:
    """Return the visible and audible state of the board."""
    outputs = controller.board.outputs
    return {
        "notes": [note._asdict() for note in controller.notes],
        "lcd": outputs.lcd,
        "servos": {str(port): pulse for port, pulse in outputs.servos.items()},
        "power": dict(outputs.power),
        "digital_out": controller.board.digital_out,
        "charging": controller.board.battery.charging.name.lower(),
        "shutdown_wanted": controller.board.shutdown_wanted,
        "simulator_messages": list(controller.simulator_messages),
    }

"""Scenes of what a robot feels: laser, bumpers, infrared, gyro, compass, joystick."""

import math

from acromovi.scenes.stage import Scene, SceneFailed, Stage
from bus import keys


def _laser(stage: Stage) -> None:
    scan = stage.see(keys.SCAN, what="a scan")
    finite = [(distance, index) for index, distance in enumerate(scan.ranges) if math.isfinite(distance)]
    distance, index = min(finite)
    bearing = math.degrees(scan.angle_min + index * scan.angle_increment)
    stage.say(
        f"{len(scan.ranges)} beams from {math.degrees(scan.angle_min):.0f} to {math.degrees(scan.angle_max):.0f} deg, "
        f"one scan in {scan.scan_time * 1000:.0f} ms; nearest: {distance:.2f} m at {bearing:.0f} deg"
    )


def _bumpers(stage: Stage) -> None:
    stage.say("the robot drives against the wall ahead")
    stage.ask("pose", x=14.2, y=6.1, heading=0.0)
    stage.drive(0.3, 0.0, 1.0)
    bumpers = None
    for _ in range(10):
        stage.drive(0.3, 0.0, 0.5)
        bumpers = stage.see(keys.BUMPERS)
        if any(bumpers.front):
            break
    if bumpers is None or not any(bumpers.front):
        raise SceneFailed("no segment of the front bumper was pressed")
    segments = [number for number, pressed in enumerate(bumpers.front, 1) if pressed]
    stage.say(f"front segments pressed: {segments}; wheels stalled: {bumpers.stall_left}, {bumpers.stall_right}")


def _gyro(stage: Stage) -> None:
    stage.drive(0.0, 0.5, 1.0)
    stage.say("the robot turns at 0.5 rad/s")
    stage.drive(0.0, 0.5, 0.5)
    moving = stage.see(keys.IMU, what="turn rate")
    stage.say(f"the gyro says {moving.angular_velocity.z:+.3f} rad/s (the truth: {stage.truth()['angular']:+.3f})")


def _compass(stage: Stage) -> None:
    compass = stage.see(keys.COMPASS, what="a compass reading")
    field = compass.magnetic_field
    strength = math.sqrt(field.x**2 + field.y**2 + field.z**2)
    stage.say(
        f"heading {math.degrees(compass.heading):.1f} deg (the truth: {math.degrees(stage.truth()['heading']):.1f}), "
        f"field {strength * 1e6:.1f} uT"
    )


def _joystick(stage: Stage) -> None:
    stage.ask("joystick", x=-0.5, y=0.8, button1=True)
    joystick = stage.see(keys.JOYSTICK, lambda joy: any(joy.buttons), "a pressed button")
    stage.say(f"axes {[round(float(axis), 2) for axis in joystick.axes]}, buttons {list(joystick.buttons)}")


SCENES = (
    Scene(
        "laser",
        "a SICK LMS200 on its own port becomes <robot>/scan",
        ("--robot", "powerbot:{name}", "--fit", "laser"),
        _laser,
        ("--laser", "{laser_port}"),
    ),
    Scene("bumpers", "bumper segments by the place of the contact", ("--robot", "powerbot:{name}"), _bumpers),
    Scene("gyro", "the analog gyro becomes <robot>/imu", ("--robot", "p3dx-sh:{name}", "--fit", "gyro"), _gyro),
    Scene(
        "compass",
        "the TCM2 compass becomes <robot>/compass",
        ("--robot", "p3dx-sh:{name}", "--fit", "compass"),
        _compass,
    ),
    Scene(
        "joystick",
        "the joystick, moved from the control socket",
        ("--robot", "p3dx-sh:{name}", "--fit", "joystick"),
        _joystick,
    ),
)

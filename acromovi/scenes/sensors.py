"""Scenes of sensors: laser, bumpers, infrared, gyro, compass, joystick, camera heads and the camera."""

import math
from pathlib import Path

from acromovi.scenes.stage import Scene, SceneFailed, SceneStage
from bus import keys, messages
from p2os import SipFlag

PICTURE = Path("picture.jpg")
PICTURES_WITHIN_S = 60.0  # pictures are the first that the emulator gives up while the machine is too busy


def _head(stage: SceneStage) -> None:
    stage.wait_for_element("ptz")
    stage.say(f"out of reach: {stage.is_refused(keys.LOOK, pan=3.0)}")
    head = stage.look(0.5, 0.2, 2.0)
    stage.say(f"pan {math.degrees(head.pan):+.1f} deg, tilt {math.degrees(head.tilt):+.1f} deg, zoom {head.zoom:.1f}")


def _camera(stage: SceneStage) -> None:
    first = stage.see(keys.CAMERA, what="a picture", within=PICTURES_WITHIN_S)
    PICTURE.write_bytes(bytes(first.data))
    stage.say(f"{len(first.data)} bytes of {first.format} from {stage.robots.robots[0]['camera_url']}, in {PICTURE}")
    stage.wait_for_element("ptz")
    stage.look(0.6)
    second = stage.see(
        keys.CAMERA, lambda picture: bytes(picture.data) != bytes(first.data), "another picture", PICTURES_WITHIN_S
    )
    PICTURE.with_stem("picture-left").write_bytes(bytes(second.data))
    stage.say("the head looks to the left: the picture is another")


def _laser(stage: SceneStage) -> None:
    scan = stage.see(keys.SCAN, what="a scan")
    finite = [(distance, index) for index, distance in enumerate(scan.ranges) if math.isfinite(distance)]
    distance, index = min(finite)
    bearing = math.degrees(scan.angle_min + index * scan.angle_increment)
    stage.say(
        f"{len(scan.ranges)} beams from {math.degrees(scan.angle_min):.0f} to {math.degrees(scan.angle_max):.0f} deg, "
        f"one scan in {scan.scan_time * 1000:.0f} ms; nearest: {distance:.2f} m at {bearing:.0f} deg"
    )


def _bumpers(stage: SceneStage) -> None:
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


def _gyro(stage: SceneStage) -> None:
    stage.tell(keys.TURN, angle=3.0)
    stage.say("the robot turns by 3 rad")
    turning = stage.see(keys.IMU, lambda imu: imu.angular_velocity.z > 0.3, "a turn that the gyro feels")
    truth = stage.truth()["angular"]
    stage.say(f"the gyro says {turning.angular_velocity.z:+.3f} rad/s (the truth: {truth:+.3f})")


def _controller_gyro(stage: SceneStage) -> None:
    stage.tell(keys.TURN, angle=3.0)
    stage.see(
        keys.ODOM, lambda odometry: abs(messages.heading(odometry.pose.pose.orientation) - 3.0) < 0.03, "the turn"
    )
    said = messages.heading(stage.see(keys.ODOM).pose.pose.orientation)
    true = stage.truth()["heading"]
    stage.say(
        f"after a turn of 3 rad odometry says {said:.3f} rad, the truth is {true:.3f}: the gyro corrects the wheels"
    )


def _infrared(stage: SceneStage) -> None:
    stage.ask("pose", x=14.2, y=6.1, heading=0.0)
    for _ in range(20):
        stage.drive(0.2, 0.0, 0.3)
        seen = [one.header.frame_id for one in stage.see(keys.IR).ranges if one.range == -math.inf]
        if seen:
            stage.say(f"a wall ahead: {', '.join(seen)}")
            return
    raise SceneFailed("the infrared sensors did not see the wall")


def _ledge(stage: SceneStage) -> None:
    stage.ask("pose", x=4.0, y=3.3, heading=0.0)
    for _ in range(20):
        stage.drive(0.2, 0.0, 0.3)
        flags = stage.see(keys.STATE).flags
        if flags & (SipFlag.FAR_LEDGE | SipFlag.NEAR_LEDGE):
            stage.say(f"stairs ahead: far {bool(flags & SipFlag.FAR_LEDGE)}, near {bool(flags & SipFlag.NEAR_LEDGE)}")
            return
    raise SceneFailed("the ledge sensors did not see the stairs")


def _compass(stage: SceneStage) -> None:
    compass = stage.see(keys.COMPASS, what="a compass reading")
    field = compass.magnetic_field
    strength = math.sqrt(field.x**2 + field.y**2 + field.z**2)
    stage.say(
        f"the robot faces east, along the world's x axis: {math.degrees(compass.heading):.1f} deg from north, "
        f"field {strength * 1e6:.1f} uT"
    )


def _joystick(stage: SceneStage) -> None:
    stage.ask("joystick", x=-0.5, y=0.8, button1=True)
    joystick = stage.see(keys.JOYSTICK, lambda joy: any(joy.buttons), "a pressed button")
    axes, buttons = [round(float(axis), 2) for axis in joystick.axes], [int(button) for button in joystick.buttons]
    stage.say(f"axes {axes}, buttons {buttons}")


SCENES = (
    Scene(
        "laser",
        "a SICK LMS200 on its own port becomes <robot>/scan",
        "--robot powerbot:{name} --fit laser",
        _laser,
        "--laser {laser_port}",
    ),
    Scene("bumpers", "bumper segments by the place of the contact", "--robot powerbot:{name}", _bumpers),
    Scene("infrared", "the PowerBot's infrared sensors become <robot>/ir", "--robot powerbot-sh:{name}", _infrared),
    Scene(
        "ledge",
        "sensors that look over an edge of the floor",
        "--robot p3dx-sh:{name} --fit ledge --world gripper-lab",
        _ledge,
    ),
    Scene("gyro", "the analog gyro becomes <robot>/imu", "--robot p3dx-sh:{name} --fit gyro", _gyro),
    Scene(
        "controller-gyro",
        "a gyro inside the controller, which corrects the odometry",
        "--robot p3dx-sh:{name} --fit gyro:controller",
        _controller_gyro,
    ),
    Scene("compass", "the TCM2 compass becomes <robot>/compass", "--robot p3dx-sh:{name} --fit compass", _compass),
    Scene(
        "joystick", "the joystick, moved from the control socket", "--robot p3dx-sh:{name} --fit joystick", _joystick
    ),
    Scene("ptz", "a Canon VC-C4 behind AUX1", "--robot p3dx-sh:{name} --fit ptz:vcc4", _head),
    Scene("visca", "a Sony EVI-D30 behind AUX1", "--robot p3dx-sh:{name} --fit ptz:evid30", _head),
    Scene(
        "camera",
        "an IP camera on the head; leaves picture.jpg",
        "--robot p3dx-sh:{name} --fit ptz:vcc4,camera:320x240@10",
        _camera,
        "--camera {camera_url}",
    ),
)

"""Make the pictures of the documentation: `python tools/make_pictures.py [FOLDER]`, by default `docs/pictures`.

Each is made by the product itself, in virtual time, so equal code gives equal files. It takes about 15 s.

drive.png: an emulated PowerBot drives a round of the office, as in `make demo`; true path and odometry path.
team.png: the team of `acromovi up acromovi` in its world, drawn by the renderer of the emulated cameras.
navigation.png: a mission through an unknown house, as `acromovi navigate picture` shows it.
texture_lab.png: a robot with the target in a world with patterns, as another robot's camera sees it.
"""

import sys
from collections.abc import Iterable
from math import atan, degrees, pi, radians, tan
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

import configs
from acromovi.demo import draw_drive
from acromovi.lockstep import Lockstep
from acromovi.missions.course import ROBOT, Course
from acromovi.navigation.mission_picture import draw
from acromovi.navigation.snapshot import Snapshot
from apps.waypoints import Follower
from bus import Sample, keys, messages
from configs.team_file import TeamRobot, read_team
from geometry import Pose2D
from p2os import RobotModel
from p2os_emu.fit import read_fit
from p2os_emu.world import World, load_world
from p2os_emu.world.engine import engine
from p2os_emu.world.mirror import FAR, NEAR, Mirror
from p2os_emu.world.view import View
from tools.small_png import make_small

FOLDER = Path(__file__).resolve().parents[1] / "docs" / "pictures"
PERIOD = 0.1  # s between two velocities
LIMIT = 120.0  # s of virtual time for the round
SIZE = 900, 680  # pixels of the picture of the team
ABOVE = View(8.0, 4.6, 15.2, pi / 2, -1.48, 1.1)  # from above, a little from the south


def drive(folder: Path) -> None:
    """Drive the route of the demo, and draw both paths."""
    world = load_world("office")
    with Lockstep(world, {"powerbot": "powerbot"}, seed=1) as lockstep:
        bus = lockstep.bus()
        poses: list[Pose2D] = []

        def hear(sample: Sample) -> None:
            pose = messages.decode(keys.ODOM.type_name, sample.payload).pose.pose
            poses.append(Pose2D(pose.position.x, pose.position.y, messages.heading(pose.orientation)))

        bus.subscribe(keys.ODOM.key("powerbot"), hear)
        lockstep.run_until(lambda: bool(poses), 10.0)
        start, follower = lockstep.truth("powerbot"), Follower(world.routes["round"])
        true_path, odometry_path = [], []
        while not follower.is_done:
            assert lockstep.time < LIMIT, "the robot does not come round"
            true_path.append(lockstep.truth("powerbot"))
            odometry_path.append(start.compose(poses[-1]))
            twist = follower.steer(odometry_path[-1])
            bus.put(keys.CMD_VEL.key("powerbot"), messages.twist(twist.linear, twist.angular))
            lockstep.run(PERIOD)
    draw_drive(folder / "drive.png", world, true_path, odometry_path)
    make_small(folder / "drive.png")


def team(folder: Path) -> None:
    """Draw the robots of a team in their world from above, each with its name."""
    file = read_team("acromovi")
    mirror = Mirror()
    with World(load_world(file.world), perfect=True) as world:
        for robot in file.robots:
            model, fit = read_fit(robot.fit, configs.load(RobotModel, "robots", robot.model))
            assert robot.at_m is not None
            world.add_robot(robot.name, model, Pose2D(*robot.at_m, radians(robot.heading_deg)), fit)
        known: set[int] = set()
        while (news := world.sight.news(known)).new:
            mirror.apply(news)
            known |= news.new.keys()
    image = Image.fromarray(mirror.draw(ABOVE, *SIZE))
    mirror.close()
    _label(image, file.robots)
    image.save(folder / "team.png")
    make_small(folder / "team.png")


def navigation(folder: Path) -> None:
    """Send a robot through a house, and draw the mission on its way."""
    world = load_world("house")
    with Course(world, "p3dx-sh", seed=1) as course:
        course.tell(world.places["guest-room"], mission="guest-room")
        course.run(11.0)
        shot = Snapshot(
            ROBOT,
            course.ask("path_planning", "picture"),
            course.ask("motion_fuser", "commands"),
            course.ask("robot_base_server", "robot"),
        )
    draw(folder / "navigation.png", shot)
    make_small(folder / "navigation.png")


def texture_lab(folder: Path) -> None:
    """Draw what a robot's camera sees of another one with a target, in the world for vision."""
    fits = {"leader": "target", "follower": "camera:640x360"}
    with Lockstep(load_world("texture-lab"), dict.fromkeys(fits, "p3dx-sh"), fits=fits, seed=4) as lockstep:
        lockstep.world.place("leader", Pose2D(3.6, 3.6, 0.3))
        lockstep.world.place("follower", Pose2D(1.2, 4.0, -0.12))
        Image.fromarray(lockstep.image("follower")).save(folder / "texture_lab.png")
    make_small(folder / "texture_lab.png")


def _label(image: Image.Image, robots: Iterable[TeamRobot]) -> None:
    """Write each robot's name and model beside it."""
    pen, font = ImageDraw.Draw(image), ImageFont.load_default(15)
    for robot in robots:
        assert robot.at_m is not None
        x, y = _pixel(*robot.at_m, 0.4)
        pen.text((x - 40, y - 38), f"{robot.name} ({robot.model})", "#111827", font, stroke_width=3, stroke_fill="#fff")


def _pixel(x: float, y: float, z: float) -> tuple[float, float]:
    """Where a point of the world is in the picture of the team."""
    width, height = SIZE
    vertical = degrees(2 * atan(tan(ABOVE.field_of_view / 2) * height / width))
    seen = np.reshape(engine.computeViewMatrix(ABOVE.eye, ABOVE.ahead, ABOVE.up), (4, 4)).T
    shown = np.reshape(engine.computeProjectionMatrixFOV(vertical, width / height, NEAR, FAR), (4, 4)).T
    across, up, _, depth = shown @ seen @ (x, y, z, 1.0)
    return (1 + across / depth) * width / 2, (1 - up / depth) * height / 2


def main(arguments: list[str]) -> None:
    """Make all pictures."""
    folder = Path(*arguments) if arguments else FOLDER
    folder.mkdir(parents=True, exist_ok=True)
    for make in (drive, team, navigation, texture_lab):
        make(folder)
        print(folder / f"{make.__name__}.png")


if __name__ == "__main__":
    main(sys.argv[1:])

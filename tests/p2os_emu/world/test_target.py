"""The target at the back of a robot: what cameras see of it, and that nothing else notices it."""

import io
from collections.abc import Iterator
from math import cos, degrees, pi, radians, sin

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

import configs
from acromovi.lockstep import Lockstep
from bus import keys
from configs.target_file import target_file
from geometry import Pose2D
from p2os import RobotModel
from p2os_emu.accessories.evid30 import EviD30
from p2os_emu.accessories.lms200 import ScannerModel
from p2os_emu.camera.jpeg import encode_jpeg
from p2os_emu.fit import BARE, Fit
from p2os_emu.target_model import target_of, target_on
from p2os_emu.truth_rows import robot_row
from p2os_emu.world import Block, World, WorldError, WorldSpec, load_world
from p2os_emu.world.chassis import HULL_TOP
from p2os_emu.world.mirror import Mirror
from p2os_emu.world.view import View
from vision.camera_model import PinholeModel
from vision.colours import ColourTable
from vision.target import TargetFinder, TargetShape, TargetStatus

WIDTH, HEIGHT, FIELD = 320, 240, radians(60.0)
CAMERA = PinholeModel.from_field_of_view(WIDTH, HEIGHT, FIELD)
FITTED = Fit({"target": ""})
ROOM = WorldSpec(
    "room",
    walls=tuple(Block(5 * cos(at), 5 * sin(at), at, 0.1, 10.0, 2.0) for at in (0.0, pi / 2, pi, -pi / 2)),
    furniture=(
        Block(4.5, 1.0, 0.0, 0.6, 1.2, 0.8, colour="blue"),
        Block(-1.0, 4.5, 0.0, 1.5, 0.6, 1.8, colour="green"),
        Block(-4.5, -1.5, 0.0, 0.6, 2.0, 0.7, colour="red"),
        Block(1.5, -4.5, 0.0, 1.5, 0.6, 1.5, colour="pink"),
    ),
)


class Leader:
    """A robot in the room, drawn from anywhere."""

    def __init__(self, model: str = "p3dx-sh", fit: Fit = FITTED) -> None:
        self.model = configs.load(RobotModel, "robots", model)
        self.world = World(ROOM, perfect=True)
        self.world.add_robot("leader", self.model, Pose2D(), fit)
        self.mirror = Mirror()
        self._known: set[int] = set()

    def target(self, robot: Pose2D) -> Pose2D:
        """The true pose of its target, when the robot has been put somewhere."""
        self.world.place("leader", robot)
        return robot.compose(target_on(self.model, target_file()))

    def draw(self, view: View, quality: int = 80) -> NDArray[np.uint8]:
        """A picture in the order of OpenCV, as the camera's JPEG has it."""
        news = self.world.sight.news(self._known)
        self.mirror.apply(news)
        self._known |= news.new.keys()
        file = encode_jpeg(self.mirror.draw(view, WIDTH, HEIGHT), quality)
        return np.ascontiguousarray(np.asarray(Image.open(io.BytesIO(file)))[:, :, ::-1])

    def close(self) -> None:
        self.mirror.close()
        self.world.close()


@pytest.fixture(scope="module")
def leader() -> Iterator[Leader]:
    leader = Leader()
    yield leader
    leader.close()


@pytest.fixture(scope="module")
def finder(leader: Leader) -> TargetFinder:
    """Trained from one picture at 1 m."""
    shape, table = TargetShape(), ColourTable()
    picture = leader.draw(seen_from(leader.target(Pose2D()), 1.0, 0.0, 0.0))
    for channel, corners in enumerate(shape.corners(), 1):
        outline = CAMERA.pixels_of(corners + np.array([1.0, 0.0, 0.0]))
        left, top = (outline.min(axis=0) + 3).astype(int).tolist()
        right, bottom = (outline.max(axis=0) - 3).astype(int).tolist()
        table.train(channel, picture, (left, top, right - left, bottom - top))
    return TargetFinder(shape, table, CAMERA)


def seen_from(target: Pose2D, distance: float, bearing: float, orientation: float, tilt: float = 0.0) -> View:
    """The view of a camera that has a target at a distance (m), a bearing, and a heading relative to its own."""
    heading = target.heading - orientation
    x, y = target.x - distance * cos(heading + bearing), target.y - distance * sin(heading + bearing)
    return View(x, y, target_file().middle_m, heading, tilt, FIELD)


def test_poses_of_the_drawn_target_are_those_of_the_leader(leader: Leader, finder: TargetFinder) -> None:
    """On poses that nothing was tuned on."""
    errors = []
    for seed in range(41000, 41060):
        rng = np.random.default_rng(seed)
        distance, aspect, tilt = rng.uniform(0.6, 3.0), radians(rng.uniform(-60, 60)), radians(rng.uniform(-5, 5))
        bearing = radians(rng.uniform(-15, 15)) if distance > 0.9 else radians(rng.uniform(-4, 4))
        target = leader.target(Pose2D(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-pi, pi)))
        pose = finder.find(leader.draw(seen_from(target, distance, bearing, aspect + bearing, tilt)), tilt).pose
        if pose is not None:
            off = pose.distance / distance - 1, pose.bearing - bearing, pose.orientation - aspect - bearing
            errors.append(np.abs(off))
            assert errors[-1][2] < radians(12), seed
    assert len(errors) >= 54
    relative, bearing, orientation = np.median(errors, axis=0)
    assert relative < 0.03
    assert degrees(bearing) < 0.5
    assert degrees(orientation) < 5.0


def test_from_ahead_the_target_has_no_colours(leader: Leader, finder: TargetFinder) -> None:
    for aspect in (-60, -20, 0, 45):
        view = seen_from(leader.target(Pose2D()), 1.5, 0.0, pi + radians(aspect))
        assert finder.find(leader.draw(view)).status is TargetStatus.NOT_SEEN


@pytest.mark.parametrize("model", ["p3dx-sh", "powerbot-sh", "p2dx"])
def test_a_robots_own_camera_never_sees_its_target(model: str) -> None:
    """With pan as far as any head goes."""

    def seen(fit: str) -> list[bytes]:
        with Lockstep(ROOM, {"happy": model}, fits={"happy": fit}, perfect=True) as lockstep:
            lockstep.world.place("happy", Pose2D())
            camera = lockstep._emulator.robots["happy"].microcontroller.board.aux[1].device
            assert isinstance(camera, EviD30)
            head = camera.head
            pictures = []
            for pan, tilt in ((0.0, 0.0), (radians(100), 0.0), (radians(-100), 0.0), (radians(100), radians(-25))):
                head.pan.position, head.tilt.position = pan, tilt
                pictures.append(lockstep.image("happy").tobytes())
            return pictures

    assert seen("ptz:evid30,camera:96x72,target") == seen("ptz:evid30,camera:96x72")


def test_sensors_and_physics_do_not_notice_the_target() -> None:
    file = target_file()
    bottom = file.middle_m - file.height_m / 2
    assert bottom > HULL_TOP
    assert bottom > configs.load(ScannerModel, "accessories", "lms200").height_m

    def course(leader_fit: str) -> tuple[bytes, bytes, list[bytes]]:
        robots = dict.fromkeys(("leader", "follower"), "p3dx-sh")
        scans: list[bytes] = []
        fits = {"leader": leader_fit, "follower": "laser"}
        with Lockstep(load_world("empty"), robots, fits=fits, seed=3) as lockstep:
            lockstep.world.place("leader", Pose2D(1.5, 0.0))
            lockstep.world.place("follower", Pose2D())
            bus = lockstep.bus()
            bus.subscribe(keys.SCAN.key("follower"), lambda sample: scans.append(sample.payload))
            lockstep.run(1.5)
            bus.query(keys.MOVE.key("leader"), {"distance": 0.5})
            lockstep.run(2.5)
            return lockstep.wire("leader"), lockstep.wire("follower"), scans

    assert course("target") == course("")


def test_truth_has_the_place_of_the_target_and_none_where_there_is_none() -> None:
    fits = {"happy": "target"}
    with Lockstep(ROOM, {"happy": "p3dx-sh", "grumpy": "p3dx-sh"}, fits=fits, perfect=True) as lockstep:
        lockstep.world.place("happy", Pose2D(1.0, 2.0, pi / 2))
        target = lockstep.target("happy")
        assert (target.x, target.y, target.heading) == pytest.approx((1.0, 2.0 - 0.301 + 0.07, pi / 2))
        rows = {name: robot_row(lockstep._emulator, robot) for name, robot in lockstep._emulator.robots.items()}
        assert rows["happy"]["target"] == {"x": pytest.approx(-0.231), "y": 0.0, "height": 0.45, "heading": 0.0}
        assert rows["grumpy"]["target"] is None
        with pytest.raises(WorldError, match="there is no target on 'grumpy'; fit it with `target`"):
            lockstep.target("grumpy")
    assert target_of(BARE) is None


def test_shape_and_colours_have_one_source() -> None:
    file, shape = target_file(), TargetShape()
    assert (shape.width, shape.height, shape.span, shape.depth) == (
        file.width_m,
        file.height_m,
        file.span_m,
        file.depth_m,
    )

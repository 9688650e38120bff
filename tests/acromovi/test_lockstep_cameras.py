"""Cameras in lockstep: pictures drawn in step with the world, on the bus at the camera's rate."""

import io
from collections.abc import Iterator
from math import pi, radians, tan

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

import configs
from acromovi.lockstep import Lockstep
from bus import Bus, Sample, keys, messages
from gateway.settings import CameraSettings, Settings
from geometry import Pose2D
from p2os_emu.camera.camera_process import CameraModel
from p2os_emu.camera.jpeg import encode_jpeg
from p2os_emu.world import STEP, WorldError, WorldSpec, load_world
from p2os_emu.world.movable import Movable, Shape

ROBOT = "happy"
QUALITY = configs.load(CameraModel, "accessories", "camera").quality
POST = Movable("post", Shape.CYLINDER, Pose2D(3.0, 0.0), 0.4, 0.4, 1.2, 5.0, 0.5, "red")
ROOM = WorldSpec("room", objects=(POST,))


class Viewer:
    """A subscriber of a camera: stamps (s) and JPEG files of the pictures that came."""

    def __init__(self, bus: Bus, robot: str = ROBOT) -> None:
        self.stamps: list[float] = []
        self.jpegs: list[bytes] = []
        self.subscription = bus.subscribe(keys.CAMERA.key(robot), self._on_picture)

    def _on_picture(self, sample: Sample) -> None:
        message = messages.decode(sample.type_name, sample.payload)
        self.stamps.append(messages.stamp_ns(message.header) / messages.NS_PER_S)
        self.jpegs.append(bytes(message.data))
        assert (message.format, message.header.frame_id) == ("jpeg", f"{ROBOT}/camera")


def of(fit: str, seed: int = 0, world: WorldSpec = ROOM) -> Lockstep:
    return Lockstep(world, {ROBOT: "p3dx-sh"}, fits={ROBOT: fit}, seed=seed, perfect=True)


@pytest.fixture
def lockstep() -> Iterator[Lockstep]:
    with of("camera:64x48@7.5") as lockstep:
        lockstep.run(1.5)
        yield lockstep


def red_column(picture: NDArray[np.uint8]) -> float | None:
    """Mean column of what is red, relative to the middle; None where nothing is."""
    red, green, blue = np.moveaxis(picture.astype(int), 2, 0)
    columns = np.nonzero((red > 60) & (red > 2 * green) & (red > 2 * blue))[1]
    return float(columns.mean() + 0.5 - picture.shape[1] / 2) if len(columns) > 5 else None


def test_pictures_come_at_the_rate_of_the_camera_stamped_with_their_exposure(lockstep: Lockstep) -> None:
    viewer = Viewer(lockstep.bus())
    lockstep.run(2.0)
    assert len(viewer.stamps) == 15
    assert np.diff(viewer.stamps) == pytest.approx(1 / 7.5)
    assert Image.open(io.BytesIO(viewer.jpegs[-1])).size == (64, 48)


def test_exposures_are_at_multiples_of_the_period_also_for_who_subscribed_before_the_robot_came() -> None:
    with of("camera:64x48@4") as lockstep:
        viewer = Viewer(lockstep.bus())
        lockstep.run(3.1)
        assert len(viewer.stamps) > 6
        assert np.remainder(np.array(viewer.stamps) + 1e-6, 0.25) == pytest.approx(0.0, abs=1e-5)


def test_a_picture_is_drawn_only_while_somebody_subscribes(lockstep: Lockstep, monkeypatch: pytest.MonkeyPatch) -> None:
    drawn: list[float] = []
    jpeg = lockstep._cameras.jpeg

    def counted(name: str) -> bytes:
        drawn.append(lockstep.time)
        return jpeg(name)

    monkeypatch.setattr(lockstep._cameras, "jpeg", counted)
    lockstep.run(1.0)
    assert drawn == []
    viewer = Viewer(lockstep.bus())
    lockstep.run(1.0)
    viewer.subscription.close()
    lockstep.run(1.0)
    assert len(drawn) == len(viewer.stamps) == pytest.approx(7.5, abs=0.5)


def test_a_published_picture_shows_the_world_at_its_stamp(lockstep: Lockstep) -> None:
    bus = lockstep.bus()
    viewer = Viewer(bus)
    for step in range(48):
        bus.put(keys.CMD_VEL.key(ROBOT), messages.twist(0.0, 0.3))
        now, there = lockstep.time, encode_jpeg(lockstep.image(ROBOT), QUALITY)
        lockstep.run(STEP)
        if viewer.stamps and viewer.stamps[-1] == pytest.approx(now):
            assert viewer.jpegs[-1] == there, step
    assert len(set(viewer.jpegs)) == len(viewer.jpegs) == 3  # the robot turns


def test_the_same_seed_gives_the_same_pictures_and_a_picture_in_between_changes_nothing() -> None:
    def pictures(seed: int, looks: bool) -> list[bytes]:
        with of("camera:64x48@5", seed, load_world("people-lab")) as lockstep:
            viewer = Viewer(lockstep.bus())
            for _ in range(6):
                lockstep.run(0.5)
                if looks:
                    lockstep.image(ROBOT)
            assert len(viewer.jpegs) > 8
            return viewer.jpegs

    assert pictures(1, looks=False) == pictures(1, looks=True)


def test_two_robots_see_each_other_from_where_they_are() -> None:
    fits = dict.fromkeys(("happy", "grumpy"), "camera:64x48")
    with Lockstep(ROOM, dict.fromkeys(fits, "p3dx-sh"), fits=fits, perfect=True) as lockstep:
        lockstep.world.place("happy", Pose2D(0.0, 0.0))
        lockstep.world.place("grumpy", Pose2D(6.0, 0.0, pi))
        views = [lockstep.view(name) for name in fits]
        assert views[0].x == pytest.approx(0.1)
        assert views[1].x == pytest.approx(5.9)
        assert all(abs(red_column(lockstep.image(name)) or 9.9) < 2.0 for name in fits)


def test_view_and_picture_follow_the_head() -> None:
    with of("ptz:evid30,camera:96x72") as lockstep:
        lockstep.run(5.0)
        straight = red_column(lockstep.image(ROBOT))
        assert straight == pytest.approx(0.0, abs=1.5)
        lockstep.bus().query(keys.LOOK.key(ROBOT), {"pan": radians(10), "tilt": radians(5), "zoom": 1.5})
        lockstep.run(4.0)
        view = lockstep.view(ROBOT)
        assert view.heading - lockstep.truth(ROBOT).heading == pytest.approx(radians(10), abs=0.01)
        assert view.tilt == pytest.approx(radians(5), abs=0.01)
        assert view.field_of_view < radians(40)
        turned = red_column(lockstep.image(ROBOT))
        assert turned is not None
        assert turned > 15


@pytest.mark.parametrize(
    ("fit", "settings", "angle"),
    [
        ("camera", Settings(emulated=True), radians(60)),
        ("camera", Settings(emulated=True, camera=CameraSettings(0.8)), 0.8),
        ("camera,ptz:evid30", Settings(emulated=True), None),
    ],
)
def test_the_description_has_size_and_field_of_view_of_the_camera(
    fit: str, settings: Settings, angle: float | None
) -> None:
    with Lockstep(ROOM, {ROBOT: "p3dx-sh"}, fits={ROBOT: fit}, settings=settings) as lockstep:
        lockstep.run(1.5)
        elements = lockstep.bus().query(keys.DESCRIPTION.key(ROBOT))[0].value["elements"]
        (described,) = (each for each in elements if each["name"] == "camera")
        assert described["size"] == [320, 240]
        assert described["field_of_view"] == (None if angle is None else pytest.approx(angle))


def test_a_robot_without_a_camera_has_no_pictures_and_costs_no_mirror() -> None:
    with of("gripper") as lockstep:
        lockstep.run(1.0)
        with pytest.raises(WorldError, match="no camera on 'happy'; fit it with `camera`\\. Robots with one: none"):
            lockstep.image(ROBOT)
        with pytest.raises(WorldError, match="no camera on 'grumpy'"):
            lockstep.view("grumpy")


def test_a_follower_sees_the_target_where_it_truly_is() -> None:
    """From `target` and `view`, by which a judge scores what a follower finds."""
    fits = {"leader": "target", ROBOT: "camera:160x120"}
    with Lockstep(WorldSpec("room"), dict.fromkeys(fits, "p3dx-sh"), fits=fits, perfect=True) as lockstep:
        lockstep.world.place(ROBOT, Pose2D(1.0, 1.0, 0.5))
        x, y = Pose2D(1.0, 1.0, 0.5).transform(1.8, 0.2)
        lockstep.world.place("leader", Pose2D(x, y, 0.5))
        target, view = lockstep.target("leader"), lockstep.view(ROBOT)
        ahead, left = Pose2D(view.x, view.y, view.heading).locate(target.x, target.y)
        assert (ahead, left) == pytest.approx((1.8 - 0.1 - 0.231, 0.2))
        red, green, blue = np.moveaxis(lockstep.image(ROBOT).astype(int), 2, 0)
        columns = np.nonzero((green > 2 * red) & (green > 2 * blue))[1]  # the centre
        assert columns.mean() == pytest.approx(80 - 160 / 2 / tan(radians(30)) * left / (ahead - 0.07), abs=1.0)

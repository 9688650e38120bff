"""What a camera sees: the world drawn from its looks, far from its physics."""

from collections.abc import Iterator
from math import pi, radians, tan

import numpy as np
import pytest
from numpy.typing import NDArray

from configs import load
from geometry import Pose2D
from p2os import RobotModel
from p2os_emu.fit import Fit
from p2os_emu.world import Block, MovingDoor, Person, World, WorldSpec
from p2os_emu.world.floor import PIXELS, Floor, Texture, picture
from p2os_emu.world.mirror import SKY, Mirror
from p2os_emu.world.movable import Movable, Shape
from p2os_emu.world.sight import SceneChanges
from p2os_emu.world.view import View

WIDTH, HEIGHT = 64, 48
FIELD = radians(60.0)
BALL = Movable("ball", Shape.CYLINDER, Pose2D(3.0, 0.0), 0.4, 0.4, 1.2, 2.0, 0.5, "red")


@pytest.fixture
def mirror() -> Iterator[Mirror]:
    mirror = Mirror()
    yield mirror
    mirror.close()


def world_of(*blocks: Block, objects: tuple[Movable, ...] = ()) -> World:
    return World(WorldSpec("test", furniture=blocks, objects=objects), perfect=True)


def view(pan: float = 0.0, tilt: float = 0.0, pose: Pose2D | None = None, field: float = FIELD) -> View:
    return View.on(pose or Pose2D(), 0.0, 0.5, pan, tilt, field)


def reds(drawn: NDArray[np.uint8]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Rows and columns of what is red."""
    red, green, blue = (drawn[:, :, channel].astype(int) for channel in range(3))
    rows, columns = np.nonzero((red > 60) & (red > 2 * green) & (red > 2 * blue))
    return rows, columns


def middle_column(drawn: NDArray[np.uint8]) -> float:
    _, columns = reds(drawn)
    assert len(columns) > 0, "nothing red is seen"
    return float(columns.mean()) + 0.5


@pytest.mark.parametrize("pan", [-0.35, -0.1, 0.0, 0.2, 0.4])
def test_object_is_where_the_pan_angle_puts_it_in_the_picture(mirror: Mirror, pan: float) -> None:
    with world_of(objects=(BALL,)) as world:
        mirror.apply(world.sight.news(set()))
    column = middle_column(mirror.draw(view(pan), WIDTH, HEIGHT))
    assert column == pytest.approx(WIDTH / 2 * (1 + tan(pan) / tan(FIELD / 2)), abs=1.5)  # panned left, it goes right


def test_tilting_up_lowers_what_is_seen_and_zooming_enlarges_it(mirror: Mirror) -> None:
    with world_of(objects=(BALL,)) as world:
        mirror.apply(world.sight.news(set()))
    level, up = (reds(mirror.draw(view(tilt=tilt), WIDTH, HEIGHT))[0] for tilt in (0.0, 0.2))
    assert up.mean() > level.mean() + 3
    near = reds(mirror.draw(view(field=FIELD / 3), WIDTH, HEIGHT))[0]
    assert len(near) > 4 * len(level)


def test_sky_floor_and_walls_have_their_colours(mirror: Mirror) -> None:
    with world_of(Block(2.0, 0.0, 0.0, 0.2, 9.0, 0.5, colour="blue")) as world:
        mirror.apply(world.sight.news(set()))
    drawn = mirror.draw(view(), WIDTH, HEIGHT)
    assert tuple(drawn[2, WIDTH // 2]) == SKY
    wall = drawn[HEIGHT // 2 + 4, WIDTH // 2].astype(int)
    assert wall[2] > 2 * wall[0]
    assert len({tuple(pixel) for pixel in drawn[-1]}) > 1  # a pattern


def test_robots_come_move_and_go_in_the_mirror_as_in_the_world(mirror: Mirror) -> None:
    model = load(RobotModel, "robots", "p3dx-sh")
    known: set[int] = set()

    def follow(world: World) -> SceneChanges:
        news = world.sight.news(known)
        mirror.apply(news)
        known.update(news.new)
        known.difference_update(news.gone)
        return news

    with world_of() as world:
        follow(world)
        empty = mirror.draw(view(), WIDTH, HEIGHT)
        world.add_robot("happy", model, Pose2D(2.0, 0.0), Fit({"gripper": "pioneer"}))
        assert len(follow(world).new) == 3 + 3  # hull and wheels; lift and paddles
        there = mirror.draw(view(), WIDTH, HEIGHT)
        assert (there != empty).any()
        world.place("happy", Pose2D(2.0, 0.7))
        assert follow(world).new == {}
        moved = mirror.draw(view(), WIDTH, HEIGHT)
        before, after = (np.nonzero((drawn != empty).any(axis=2))[1].mean() for drawn in (there, moved))
        assert after < before - 5  # it went to the left
        world.remove_robot("happy")
        assert len(follow(world).gone) == 6
        assert (mirror.draw(view(), WIDTH, HEIGHT) == empty).all()


def test_news_that_nobody_took_adds_up(mirror: Mirror) -> None:
    with world_of(objects=(BALL,)) as world:
        first = world.sight.news(set())
        numbers = set(first.new)
        second = world.sight.news(numbers)
        first.add(second)
    first.add(SceneChanges(gone={max(numbers)}))
    assert max(numbers) not in first.new
    assert first.gone == set()  # nobody has heard of it
    second.add(SceneChanges(gone={max(numbers)}))
    assert second.gone == {max(numbers)}
    assert max(numbers) not in second.moved


def test_what_never_moves_is_told_once(mirror: Mirror) -> None:
    with world_of(Block(2.0, 0.0, 0.0, 0.2, 1.0, 0.5)) as world:
        known = set(world.sight.news(set()).new)
        assert world.sight.news(known) == SceneChanges()


@pytest.mark.parametrize("texture", [Texture.CHECKER, Texture.TILES, Texture.PLANKS])
def test_floor_has_two_colours_in_a_pattern(texture: Texture) -> None:
    painted = picture(Floor(texture, "white", "black", 1.0))
    assert painted.shape == (PIXELS, PIXELS, 3)
    assert {tuple(pixel) for row in painted[::101] for pixel in row} == {(242, 242, 242), (26, 26, 26)}


@pytest.mark.parametrize("pattern", [0.5, 1.0])
def test_floor_has_its_pattern_in_its_size_wherever_one_looks(mirror: Mirror, pattern: float) -> None:
    """Seen from 1 m above, a row of the picture shows so many changes of colour on so many metres."""
    floor = Floor(Texture.CHECKER, "white", "black", pattern)
    height, seen = 1.0, 4.0  # m
    down = View(5.3, -3.1, height, 0.0, -pi / 2, 2 * np.arctan(seen / 2 / height))
    with World(WorldSpec("test", floor=floor), perfect=True) as world:
        mirror.apply(world.sight.news(set()))
    row = mirror.draw(down, 400, 400)[200, :, 0] > 128
    assert np.count_nonzero(row[1:] != row[:-1]) == pytest.approx(seen / pattern, abs=1)


def test_view_looks_where_head_and_robot_point() -> None:
    seen = View.on(Pose2D(1.0, 2.0, pi / 2), 0.1, 0.4, -pi / 2, 0.3, FIELD)
    assert seen.eye == pytest.approx((1.0, 2.1, 0.4))
    along = np.subtract(seen.ahead, seen.eye)
    assert along == pytest.approx((np.cos(0.3), 0.0, np.sin(0.3)), abs=1e-9)
    assert np.dot(along, seen.up) == pytest.approx(0.0, abs=1e-9)


def test_a_camera_sees_people_and_doors_that_move(mirror: Mirror) -> None:
    person = Person("Anna", ((3.0, 0.0), (3.0, 3.0)), speed=1.0, colour="red")
    door = MovingDoor("door", (3.0, -1.6), (3.0, -0.6), colour="red", is_open=False)
    with World(WorldSpec("test", people=(person,), moving_doors=(door,)), perfect=True) as world:
        news = world.sight.news(set())
        mirror.apply(news)
        columns = reds(mirror.draw(view(), WIDTH, HEIGHT))[1]
        assert (columns < WIDTH / 2).any(), "the left half of the person"
        assert (columns > WIDTH * 0.7).any(), "the door"
        world.set_door("door", True)
        for _ in range(240):
            world.step()
        mirror.apply(world.sight.news(set(news.new)))
        later = reds(mirror.draw(view(), WIDTH, HEIGHT))[1]
    assert later.min() < columns.min(), "the person has walked to the left"
    assert later.mean() != columns.mean()

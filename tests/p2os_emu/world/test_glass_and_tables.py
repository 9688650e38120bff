"""Glass, tables and overhangs: who sees, hears, touches and passes them."""

from collections.abc import Callable
from math import inf, pi
from pathlib import Path

import numpy as np
import pytest

from geometry import Pose2D
from p2os.robot_model import RobotModel
from p2os_emu.body import ScanBeams
from p2os_emu.world import Block, RobotBody, World, WorldError, WorldSpec, load_world
from p2os_emu.world.free_space import FreeSpace
from p2os_emu.world.look import wall_look
from p2os_emu.world.shortest_path import shortest_path
from p2os_emu.world.tables import TOP_THICKNESS, TableEntry

Models = Callable[[str], RobotModel]
MakeWorld = Callable[..., World]

AHEAD = ScanBeams(0.0, 0.0, 0.2, -pi / 2, pi / 180, 181, 30.0)
PANE = Block(1.5, 0.0, 0.0, 0.1, 4.0, 2.0, "pane", glass=True)
TABLE = TableEntry((2.0, 0.0), (0.8, 1.4))
GLAZED = WorldSpec("glazed", walls=(PANE,))
DINING = WorldSpec("dining room", furniture=TABLE.blocks())
FRONT_DISCS = (3, 4)


def drive(world: World, body: RobotBody, seconds: float) -> float:
    """Drive ahead, and return how far the robot came, m."""
    body.drive(0.4, 0.4)
    for _ in range(round(seconds * 120)):
        world.step()
    return body.pose.x


def test_a_scanner_sees_through_glass_which_sonar_hears_and_robots_touch(model: Models, make_world: MakeWorld) -> None:
    world = make_world(GLAZED)
    body = world.add_robot("robot", model("p3dx-sh"), Pose2D())
    assert np.all(np.isinf(body.scan(AHEAD).ranges))
    assert min(body.ping(FRONT_DISCS)) == pytest.approx(1.45 - body.chassis.front, abs=0.1)
    assert drive(world, body, 5.0) < 1.45
    assert {touch.what for touch in world.touches("robot").last} == {"pane"}


def test_infrared_sensors_miss_glass(model: Models, make_world: MakeWorld) -> None:
    shape = model("powerbot-sh")
    for glass, level in ((False, 0x00), (True, 0xFF)):
        wall = Block(shape.length_front + 0.15, 0.0, 0.0, 0.1, 4.0, 2.0, glass=glass)
        body = make_world(WorldSpec("wall", walls=(wall,))).add_robot("robot", shape, Pose2D())
        body.refresh()
        assert body.state.infrared == level


def test_of_a_pane_cameras_see_the_rails_only() -> None:
    assert sum(part.size[2] for part in wall_look(PANE)) < 0.1


def test_a_scanner_sees_the_legs_of_a_table_and_its_top_only_in_the_plane_of_the_top(
    model: Models, make_world: MakeWorld
) -> None:
    body = make_world(DINING).add_robot("robot", model("p3dx-sh"), Pose2D())
    legs, top = (
        body.scan(ScanBeams(0.0, 0.0, height, -pi / 2, pi / 720, 721, 30.0)).ranges < inf for height in (0.2, 0.72)
    )
    assert 10 < np.count_nonzero(legs) < 0.2 * np.count_nonzero(top)
    assert not legs[360]
    assert top[360]


def test_a_low_robot_passes_below_a_table_that_stops_a_tall_one(model: Models, make_world: MakeWorld) -> None:
    reached = {}
    for name in ("p3dx-sh", "peoplebot-sh"):
        world = make_world(DINING)
        body = world.add_robot("robot", model(name), Pose2D())
        reached[name] = drive(world, body, 11.0), world.touches("robot").count
    assert reached["p3dx-sh"][0] > 3.5
    assert reached["p3dx-sh"][1] == 0
    assert reached["peoplebot-sh"][0] < 1.6
    assert reached["peoplebot-sh"][1] > 0


def test_sonar_hears_the_edge_of_a_table_from_afar_and_not_from_near(model: Models, make_world: MakeWorld) -> None:
    """The cone of 15 degrees to each side, from discs 0.2 m above the floor, reaches 0.72 m after 1.94 m."""
    world = make_world(WorldSpec("edge", furniture=(Block(4.0, 0.0, 0.0, 0.8, 4.0, 0.03, "edge", bottom=0.71),)))
    body = world.add_robot("robot", model("p3dx-sh"), Pose2D())
    heard = []
    for x in (1.3, 2.6, 3.5):
        world.place("robot", Pose2D(x))
        heard.append(min(body.ping(FRONT_DISCS)) < inf)
    assert heard == [True, False, False]


def test_low_robots_can_be_put_below_a_table_and_tall_ones_cannot(model: Models, make_world: MakeWorld) -> None:
    make_world(DINING).add_robot("low", model("p3dx-sh"), Pose2D(2.0, 0.0, 0.0))
    with pytest.raises(WorldError, match="table is in the way"):
        make_world(DINING).add_robot("tall", model("peoplebot-sh"), Pose2D(2.0, 0.0, 0.0))


def test_the_shortest_way_of_a_low_robot_leads_below_a_table() -> None:
    ends = (0.0, 0.0), (4.0, 0.0)
    round_it, below = (shortest_path(DINING, *ends, 0.3, height=height) for height in (inf, 0.5))
    assert round_it is not None
    assert below is not None
    assert below.length == pytest.approx(4.0)
    assert round_it.length > 4.2
    assert not FreeSpace(DINING, 0.3).is_free((2.0, 0.0)), "without a height everything counts"


def test_a_world_file_has_tables_overhangs_and_glass(tmp_path: Path) -> None:
    path = tmp_path / "cafe.toml"
    path.write_text(
        "walls = [{ from_m = [0, 0], to_m = [4, 0], glass = true }]\n"
        'furniture = [{ at_m = [3, 3], size_m = [1, 0.3, 0.4], bottom_m = 1.2, name = "shelf" }]\n'
        'tables = [{ at_m = [1, 2], size_m = [0.8, 0.6], height_m = 0.7, leg_m = 0.04, name = "desk" }]\n'
    )
    spec = load_world(path)
    assert all(block.glass for block in spec.walls)
    shelf, *legs, top = spec.furniture
    assert (shelf.bottom, shelf.top) == pytest.approx((1.2, 1.6))
    assert [leg.top for leg in legs] == pytest.approx([0.7 - TOP_THICKNESS] * 4)
    assert (top.bottom, top.top, top.length, top.width) == pytest.approx((0.67, 0.7, 0.8, 0.6))
    assert sorted((round(leg.x, 3), round(leg.y, 3)) for leg in legs) == [
        (0.62, 1.72),
        (0.62, 2.28),
        (1.38, 1.72),
        (1.38, 2.28),
    ]
    assert {block.name for block in (*legs, top)} == {"desk"}


@pytest.mark.parametrize(
    ("entry", "reason"),
    [
        (
            "tables = [{ at_m = [0, 0], size_m = [1, 1], height_m = 0.02 }]",
            r"tables\[0\] table: height_m must be above",
        ),
        ("tables = [{ at_m = [0, 0], size_m = [1, 0.1], leg_m = 0.06 }]", "leg_m must be above 0 m, and at most half"),
        ("furniture = [{ at_m = [0, 0], size_m = [1, 1, 1], bottom_m = -1 }]", "bottom_m must be 0 m or more, not -1"),
    ],
)
def test_an_entry_that_makes_no_sense_is_refused(entry: str, reason: str, tmp_path: Path) -> None:
    path = tmp_path / "bad.toml"
    path.write_text(entry + "\n")
    with pytest.raises(WorldError, match=reason):
        load_world(path)

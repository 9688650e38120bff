"""Patterns of walls, furniture and floors, as pictures and as cameras see them."""

import pickle
from collections.abc import Sequence
from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from numpy.typing import NDArray

from geometry import Pose2D
from p2os_emu.camera.news import LARGEST
from p2os_emu.world import Block, Person, World, WorldSpec, load_world
from p2os_emu.world.floor import Floor, Texture, picture
from p2os_emu.world.mirror import Mirror
from p2os_emu.world.textures import (
    EDGE,
    PIXELS,
    VARIANTS,
    Pattern,
    SurfaceTexture,
    Textures,
    choose_texture,
    paint,
)
from p2os_emu.world.view import View

WALL = Block(2.0, 0.0, 0.0, 0.2, 6.0, 2.0)
BRICKS = WorldSpec("test", walls=(WALL,), textures=Textures(walls=(Pattern.BRICKS,)))


def drawn(spec: WorldSpec, views: Sequence[View], seed: int = 0) -> list[NDArray[np.uint8]]:
    mirror = Mirror()
    with World(spec, seed=seed, perfect=True) as world:
        mirror.apply(world.sight.news(set()))
    pictures = [mirror.draw(view, 160, 120) for view in views]
    mirror.close()
    return pictures


def at(y: float = 0.0, x: float = 0.0) -> View:
    return View(x, y, 0.6, 0.0, 0.0, 0.8)


@pytest.mark.parametrize(("pattern", "variant"), list(product(Pattern, (0, VARIANTS - 1))))
def test_a_picture_is_always_the_same_has_contrast_and_fits_its_own_edges(pattern: Pattern, variant: int) -> None:
    texture = SurfaceTexture(pattern, "cream", variant, 0.0)
    painted = paint(texture)
    assert painted.shape == (PIXELS, PIXELS, 3)
    assert (painted == paint(texture)).all()
    assert (painted != paint(texture._replace(variant=1))).any()
    grey = painted.mean(axis=2)
    assert grey.std() > 8.0
    # Motion along a wall is seen where brightness changes from one column to the next: in every quarter of the picture.
    slopes = np.abs(np.diff(grey, axis=1))
    assert min(part.mean() for part in np.array_split(slopes, 4, axis=1)) > 1.0
    across, inside = np.abs(grey[:, 0] - grey[:, -1]).mean(), slopes.mean(axis=0).max()
    assert across <= max(inside, 2.0)


def test_each_surface_has_a_pattern_of_its_list_by_the_seed() -> None:
    patterns = (Pattern.BRICKS, Pattern.CLOTH)
    chosen = [choose_texture(patterns, "red", f"seed {number}") for number in range(40)]
    assert chosen == [choose_texture(patterns, "red", f"seed {number}") for number in range(40)]
    assert {texture.pattern for texture in chosen if texture} == set(patterns)
    assert {texture.variant for texture in chosen if texture} == set(range(VARIANTS))
    assert choose_texture((), "red", "seed") is None


def test_the_seed_of_the_world_decides_what_its_walls_look_like() -> None:
    spec = replace(BRICKS, textures=Textures(walls=tuple(Pattern)))
    (one,), (again,), (other,) = (drawn(spec, [at()], seed) for seed in (1, 1, 2))
    assert (one == again).all()
    assert (one != other).any()


def test_a_picture_repeats_along_a_wall_in_its_size_and_stands_upright() -> None:
    here, there, between = drawn(BRICKS, [at(0.0), at(EDGE), at(EDGE / 2)])
    wall = slice(30, 90)  # above the skirting board
    assert np.abs(here[wall].astype(int) - there[wall]).mean() < 1.0
    assert np.abs(here[wall].astype(int) - between[wall]).mean() > 5.0
    grey = here[wall, 40:120].mean(axis=2)
    rows, columns = (np.abs(np.diff(grey.mean(axis=axis))).max() for axis in (1, 0))
    assert rows > 2 * columns  # joints between rows of bricks go all the way along, others do not


def test_every_side_of_a_box_and_its_top_are_covered() -> None:
    box = Block(0.0, 0.0, 0.3, 1.0, 0.6, 0.4)
    spec = WorldSpec("test", furniture=(box,), textures=Textures(furniture=(Pattern.POSTERS,)))
    views = [
        View(*place, heading, -0.5, 0.6)
        for place, heading in (
            ((-1.2, 0.0, 0.9), 0.0),
            ((1.2, 0.0, 0.9), np.pi),
            ((0.0, -1.2, 0.9), np.pi / 2),
            ((0.0, 1.2, 0.9), -np.pi / 2),
        )
    ]
    floor, plain = (drawn(each, views) for each in (replace(spec, furniture=()), replace(spec, textures=Textures())))
    for covered, bare, empty in zip(drawn(spec, views), plain, floor, strict=True):
        box = (bare != empty).any(axis=2)
        assert box.sum() > 5000
        assert (covered[box] != bare[box]).any(axis=1).mean() > 0.95
        assert covered[box].mean(axis=1).std() > 1.2 * bare[box].mean(axis=1).std()
        assert (covered[~box] == empty[~box]).all()


def test_people_stay_in_view_before_patterns() -> None:
    person = Person("Anna", ((1.0, 0.0), (1.0, 2.0)), speed=1.0, colour="orange")
    with_her, without = (drawn(replace(BRICKS, people=people), [at()])[0] for people in ((person,), ()))
    assert (with_her != without).any(axis=2).mean() > 0.1


def test_a_carpet_lies_on_the_floor_in_its_two_colours() -> None:
    painted = picture(Floor(Texture.CARPET, "white", "black", 0.5))
    assert painted.min() >= 26
    assert painted.max() <= 242
    assert painted.std() > 30
    assert (painted == picture(Floor(Texture.CARPET, "white", "black", 0.5))).all()


def test_the_texture_lab_shows_texture_wherever_one_looks() -> None:
    spec = load_world("texture-lab")
    views = [View(start.x, start.y, 0.45, heading, 0.0, 1.0) for start in spec.starts for heading in (0.0, 2.0, 4.0)]
    contrast = [
        tile.std()
        for seed in (7, 8)
        for seen in drawn(spec, views, seed)
        for band in np.array_split(seen[45:].mean(axis=2), 3)
        for tile in np.array_split(band, 4, axis=1)
    ]
    assert np.percentile(contrast, 2) > 2.5


def test_a_world_without_textures_and_light_is_drawn_with_neither() -> None:
    with World(load_world("office"), seed=5) as world:
        news = world.sight.news(set())
        assert news.light is None
        assert world.light is None
        assert all(part.texture is None for look, _ in news.new.values() for part in look)
    assert World(load_world("empty"), perfect=True).sight.news(set()).light is None


def test_news_of_a_world_with_patterns_reach_a_camera_process_whole_and_are_short() -> None:
    with World(load_world("texture-lab"), seed=5) as world:
        news = world.sight.news(set())
    packet = pickle.dumps(news)
    assert pickle.loads(packet) == news
    assert news.light is not None
    assert len(packet) < LARGEST / 50


def test_start_of_the_texture_lab_is_free_for_a_robot_to_turn() -> None:
    assert load_world("texture-lab").starts[0] == Pose2D(1.2, 4.0, 0.0)

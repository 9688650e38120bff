"""Light that changes by a schedule and by the seed, in the world and in pictures."""

from dataclasses import replace
from math import atan2, degrees
from pathlib import Path

import numpy as np
import pytest

from p2os_emu.world import Block, World, WorldError, WorldSpec, load_world
from p2os_emu.world.light import DIRECTION, Light, LightCourse, LightState
from p2os_emu.world.mirror import SKY, Mirror
from p2os_emu.world.sight import SceneChanges
from p2os_emu.world.view import View

VIEW = View(0.0, 0.0, 0.6, 0.0, 0.0, 1.0)
ROOM = WorldSpec("test", walls=(Block(2.0, 0.0, 0.0, 0.2, 2.0, 1.0),))
SCHEDULE = """
[light]
schedule = [{ at_s = 1.0, brightness = 1.0 }, { at_s = 2.0, brightness = 0.5 }]
"""


@pytest.fixture
def scheduled(tmp_path: Path) -> WorldSpec:
    path = tmp_path / "dim.toml"
    path.write_text(SCHEDULE)
    return replace(load_world(str(path)), walls=ROOM.walls)


def test_brightness_follows_the_schedule_and_stays_before_and_after_it(scheduled: WorldSpec) -> None:
    assert scheduled.light is not None
    course = LightCourse(scheduled.light, 1)
    states = [course.at(time) for time in (0.0, 1.0, 1.5, 2.0, 9.0)]
    assert [state.brightness for state in states] == pytest.approx([1.0, 1.0, 0.75, 0.5, 0.5])
    assert all(state.direction == pytest.approx(DIRECTION) for state in states)


def test_drift_and_turn_stay_within_their_bounds_and_follow_the_seed() -> None:
    light = Light(drift=0.3, turn_deg=40.0, period_s=10.0)

    def states(seed: int) -> list[LightState]:
        course = LightCourse(light, seed)
        return [course.at(0.5 * step) for step in range(400)]

    first = states(1)
    assert first == states(1)
    assert first != states(2)
    brightness = np.array([state.brightness for state in first])
    turned = np.array([degrees(atan2(y, x) - atan2(DIRECTION[1], DIRECTION[0])) for _, (x, y, _) in first])
    for values, most in ((brightness - 1.0, 0.3), (turned, 40.0)):
        assert most / 2 < np.abs(values).max() <= most
        assert np.abs(np.diff(values)).max() < most / 2  # it changes smoothly


def test_pictures_become_darker_with_the_light(scheduled: WorldSpec) -> None:
    mirror = Mirror()
    with World(scheduled, perfect=True) as world:
        first = world.sight.news(set())
        mirror.apply(first)
        before = mirror.draw(VIEW, 64, 48).astype(int)
        for _ in range(240):
            world.step()
        mirror.apply(world.sight.news(set(first.new)))
        after = mirror.draw(VIEW, 64, 48)
    mirror.close()
    assert after == pytest.approx(before * 0.5, abs=2.0)


def test_light_of_full_brightness_is_that_of_a_world_without_any() -> None:
    mirror = Mirror()
    with World(ROOM, perfect=True) as world:
        mirror.apply(world.sight.news(set()))
    plain = mirror.draw(VIEW, 64, 48)
    mirror.apply(SceneChanges(light=LightState(1.0, DIRECTION)))
    assert (mirror.draw(VIEW, 64, 48) == plain).all()
    mirror.apply(SceneChanges(light=LightState(1.0, (-6.0, 2.0, 1.0))))
    turned = mirror.draw(VIEW, 64, 48)
    assert turned[30, 32].mean() > plain[30, 32].mean() + 10  # the wall that faces it
    assert tuple(turned[2, 32]) == SKY
    mirror.close()


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("drift = 1.5", "light: drift must be at least 0 and less than 1"),
        ("turn_deg = 200", "light: turn_deg must be from 0 to 180"),
        ("period_s = 0", "light: period_s must be at least 0.1 s"),
        ("schedule = [{ at_s = 1, brightness = 9 }]", "light: brightness must be from 0.05 to 2"),
        (
            "schedule = [{ at_s = 1, brightness = 1 }, { at_s = 1, brightness = 1 }]",
            "light: at_s must rise from one entry of the schedule to the next",
        ),
    ],
)
def test_light_that_makes_no_sense_is_refused(tmp_path: Path, text: str, says: str) -> None:
    path = tmp_path / "wrong.toml"
    path.write_text(f"[light]\n{text}\n")
    with pytest.raises(WorldError, match=says):
        load_world(str(path))


def test_a_pattern_that_there_is_not_is_refused_with_those_that_there_are(tmp_path: Path) -> None:
    path = tmp_path / "wrong.toml"
    path.write_text('[textures]\nwalls = ["brick"]\n')
    with pytest.raises(ValueError, match="bricks"):
        load_world(str(path))

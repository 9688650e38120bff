"""Somebody is in the way, and is asked to let the robot pass."""

import math
from dataclasses import replace

from acromovi.missions.course import Course
from acromovi.missions.navigated_robot import Played
from geometry import Pose2D
from p2os_emu.world import Block, Person, WorldSpec

GOAL = (6.0, 0.0)
WALLS = (
    Block(3.0, 1.0, 0.0, 10.0, 0.1, 2.0),
    Block(3.0, -1.0, 0.0, 10.0, 0.1, 2.0),
    Block(-2.0, 0.0, math.pi / 2.0, 2.0, 0.1, 2.0),
    Block(8.0, 0.0, math.pi / 2.0, 2.0, 0.1, 2.0),
)
ANNA = Person("Anna", ((3.0, 0.0), (3.0, 0.5)), loops=True, pause=(300.0, 300.0))
"""Stands in the middle of a corridor in which no PowerBot passes her."""


def drive(anna: Person, limit: float) -> tuple[Played, int]:
    """Send a PowerBot past her; how that ended, and how often it asked."""
    world = WorldSpec("corridor", walls=WALLS, people=(anna,), starts=(Pose2D(0.0, 0.0, 0.0),))
    with Course(world, "powerbot", start=Pose2D(0.0, 0.0, 0.0)) as course:
        played = course.go(GOAL, limit=limit)
        return played, sum("asks to be let pass" in each for each in played.told)


def test_who_stands_in_the_way_steps_aside_for_a_robot_that_asks() -> None:
    played, asked = drive(ANNA, 60.0)
    assert played.state == "done", played.told
    assert asked == 1
    assert not played.touched


def test_for_who_does_not_step_aside_the_robot_waits_and_touches_nobody() -> None:
    played, asked = drive(replace(ANNA, gives_way=False), 25.0)
    assert played.state == "late", played.told
    assert asked > 1
    assert not played.touched

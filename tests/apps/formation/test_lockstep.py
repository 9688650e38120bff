"""The controller on emulated robots in virtual time, as the benchmark drives it."""

import statistics

from apps.formation.settings import FormationSettings
from benchmarks.formation import placed
from benchmarks.formation_course import FormationCourse, figure_of_eight, follow_line, straight
from benchmarks.formation_sight import SightCourse
from geometry import Pose2D
from p2os_emu.world import load_world

SETTINGS = FormationSettings.load()


def driven(seconds: float, line_seconds: float) -> FormationCourse:
    """A triangle that has driven a piece of a figure of eight, and then changes into a line."""
    start, drive = figure_of_eight(4.5, 0.25)
    starts = placed(start, "triangle", 2, SETTINGS)
    with FormationCourse(load_world("empty"), starts, "triangle", SETTINGS, seed=3, drive=drive) as course:
        course.run(seconds)
        course.formation.set_shape("line")
        course.run(line_seconds)
        assert course.touches() == []
    return course


def test_followers_keep_near_their_points_and_the_same_seed_gives_the_same_drive() -> None:
    first, again = driven(6.0, 7.0), driven(2.0, 0.0)
    for name in first.formation.members.followers:
        errors = first.track.errors(name)
        assert statistics.fmean(errors[20:60]) < 0.1
        assert errors[-1] < 0.15
        assert first.track.poses[name][:20] == again.track.poses[name]


def test_a_follower_keeps_its_point_by_sight_alone() -> None:
    starts = placed(Pose2D(), "column", 1, SETTINGS.by_sight)
    with SightCourse(load_world("empty"), starts, "column", SETTINGS, seed=3) as course:
        course.drive = follow_line(straight((0, 0), (9, 0)), 0.25)
        course.run(8.0)
        errors = course.track.errors("doc")
        assert course.touches() == []
    assert statistics.fmean(errors[30:]) < 0.2

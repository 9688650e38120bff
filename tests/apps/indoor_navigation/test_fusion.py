"""One command out of many: what must hold whatever the sources say, and whenever."""

from dataclasses import replace
from math import inf, nan
from typing import Any

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from apps.indoor_navigation.algorithms.fusion import (
    MAX_GAP,
    CommandSource,
    Fusion,
    FusionParameters,
    InvalidCommand,
    SourceCommand,
)
from apps.indoor_navigation.data import MotionCmd
from apps.indoor_navigation.parameters import shipped_parameters

EPOCH = 1.8e9  # s since 1970 at which the fuser's own clock shows zero
PARAMETERS = replace(
    shipped_parameters("motion_fuser").fusion,
    sources={
        "goto": CommandSource(max_age=0.5),
        "orienting": CommandSource(max_age=0.3, weight=2.0),
        "obstacle_avoiding": CommandSource(max_age=0.4, required=True),
    },
)
QUICK = replace(PARAMETERS, acceleration=1e6, braking=1e6, angular_acceleration=1e6, angular_braking=1e6)
ROUNDING = 1e-6

speeds = st.floats(-2.0, 2.0)
commands = st.builds(
    MotionCmd,
    stamp=st.floats(0.0, 1.5),  # s before it is heard
    source=st.sampled_from([*PARAMETERS.sources, "stranger"]),
    linear=speeds,
    angular=speeds,
    weight=st.sampled_from([0.0, 0.5, 1.0]) | st.floats(0.0, 10.0),
    limit=st.none() | st.floats(0.0, 1.0),
    back=st.none() | st.floats(0.0, 1.0),
    left=st.none() | st.floats(0.0, 1.0),
    right=st.none() | st.floats(0.0, 1.0),
)
steps = st.lists(st.tuples(st.floats(0.001, 0.4), st.none() | commands), min_size=1, max_size=30)


def command(source: str, linear: float = 0.0, angular: float = 0.0, weight: float = 1.0, **more: float) -> MotionCmd:
    return MotionCmd(more.pop("stamp", EPOCH), source, linear, angular, weight, **more)


def least(heard: list[SourceCommand], name: str, usual: float) -> float:
    """Of the limits of a name that are told."""
    told: list[float | None] = [getattr(one.command, name) for one in heard]
    return min([usual, *(limit for limit in told if limit is not None)])


def fed(*given: MotionCmd, parameters: FusionParameters = QUICK) -> Fusion:
    """Has heard these at zero, and stands."""
    fusion = Fusion(parameters)
    fusion.fuse(-0.05, EPOCH)
    for each in given:
        fusion.hear(each, 0.0, EPOCH)
    return fusion


def test_the_fused_command_is_the_weighted_mean() -> None:
    fusion = fed(
        command("goto", 0.4, 0.0, 3.0), command("obstacle_avoiding", 0.0, 1.0, 1.0), command("orienting", 9.0, 9.0, 0.0)
    )
    fused = fusion.fuse(0.0, EPOCH)
    assert (fused.linear, fused.angular) == pytest.approx((0.3, 0.25))


def test_a_source_weighs_as_the_numbers_say() -> None:
    fusion = fed(command("goto", 0.3), command("orienting", 0.0), command("obstacle_avoiding", weight=0.0))
    assert fusion.fuse(0.0, EPOCH).linear == pytest.approx(0.1)  # 1 to 2


def test_a_source_that_wants_nothing_limits_all_the_same() -> None:
    fusion = fed(command("goto", 0.5, 0.4), command("obstacle_avoiding", weight=0.0, limit=0.1))
    fused = fusion.fuse(0.0, EPOCH)
    assert (fused.linear, fused.angular, fused.limit) == (0.1, 0.4, 0.1)


def test_a_limit_forbids_no_way_back() -> None:
    fusion = fed(command("goto", -0.2), command("obstacle_avoiding", weight=0.0, limit=0.0))
    assert fusion.fuse(0.0, EPOCH).linear == -0.2


@pytest.mark.parametrize(
    ("wanted", "limits", "fused"),
    [
        ((-0.3, 0.0), {"back": 0.1}, (-0.1, 0.0)),
        ((0.0, 0.8), {"left": 0.2}, (0.0, 0.2)),
        ((0.0, -0.8), {"right": 0.0}, (0.0, 0.0)),
        ((0.3, 0.8), {"right": 0.0, "back": 0.0}, (0.3, 0.8)),
    ],
)
def test_each_limit_is_of_one_direction(
    wanted: tuple[float, float], limits: dict[str, float], fused: tuple[float, float]
) -> None:
    given = fed(command("goto", *wanted), command("obstacle_avoiding", weight=0.0, **limits)).fuse(0.0, EPOCH)
    assert (given.linear, given.angular) == pytest.approx(fused)
    assert {name: getattr(given, name) for name in limits} == limits


def test_nobody_is_waited_for() -> None:
    fusion = fed(command("goto", 0.4), command("obstacle_avoiding", weight=0.0))
    fusion.hear(command("obstacle_avoiding", weight=0.0, stamp=EPOCH + 0.6), 0.6, EPOCH + 0.6)
    assert fusion.fuse(0.6, EPOCH + 0.6).linear == 0.0  # what goto wanted is 0.6 s old


def test_without_a_required_source_the_robot_stands_at_once() -> None:
    fusion = fed(command("goto", 0.4), command("obstacle_avoiding", weight=0.0), parameters=PARAMETERS)
    for step in range(1, 8):
        moving = fusion.fuse(0.05 * step, EPOCH + 0.05 * step)
    assert moving.linear > 0.1
    fused = fusion.fuse(0.45, EPOCH + 0.45)
    assert (fused.linear, fused.angular) == (0.0, 0.0)


def test_a_source_that_hangs_and_repeats_one_reading_is_used_no_longer_than_that_reading() -> None:
    fusion = fed(command("obstacle_avoiding", 0.4))
    for step in range(1, 20):
        now = 0.04 * step + 0.01
        fusion.hear(command("obstacle_avoiding", 0.4), now, EPOCH + now)
        assert bool(fusion.fuse(now, EPOCH + now).linear) == (now < 0.4)


def test_a_clock_that_is_ahead_keeps_no_source_alive() -> None:
    fusion = fed(command("obstacle_avoiding", 0.4, stamp=EPOCH + 3600.0))
    for step in range(1, 20):
        now = 0.04 * step + 0.01
        fusion.hear(command("obstacle_avoiding", 0.4, stamp=EPOCH + 3600.0), now, EPOCH + now)
        assert bool(fusion.fuse(now, EPOCH + now).linear) == (now < 0.4)


def test_a_clock_that_is_set_makes_nothing_young_again() -> None:
    fusion = fed(command("obstacle_avoiding", 0.4))
    assert fusion.fuse(0.5, EPOCH - 3600.0).linear == 0.0


@pytest.mark.parametrize(
    "wrong",
    [
        {"linear": nan},
        {"angular": inf},
        {"weight": -1.0},
        {"weight": nan},
        {"limit": -0.1},
        {"back": -0.1},
        {"left": -0.1},
        {"right": inf},
        {"stamp": nan},
        {"linear": None},
        {"linear": "fast"},
        {"angular": True},
        {"weight": 1e300},
        {"source": None},
    ],
)
def test_nonsense_is_left_out_and_what_was_said_before_stands(wrong: dict[str, Any]) -> None:
    fusion = fed(command("obstacle_avoiding", 0.4))
    with pytest.raises(InvalidCommand):
        fusion.hear(replace(command("obstacle_avoiding", 0.1), **wrong), 0.0, EPOCH)
    assert fusion.fuse(0.1, EPOCH + 0.1).linear == 0.4


@given(steps)
def test_no_command_is_used_longer_than_its_age_limit(given_steps: list[tuple[float, MotionCmd | None]]) -> None:
    fusion, now, pasts = Fusion(QUICK), 0.0, dict[str, tuple[float, MotionCmd]]()
    for elapsed, heard in given_steps:
        now += elapsed
        if heard is not None:
            stamped = replace(heard, stamp=EPOCH + now - heard.stamp)
            fusion.hear(stamped, now, EPOCH + now)
            pasts[heard.source] = now - heard.stamp, stamped
        fused = fusion.fuse(now, EPOCH + now)
        young = [
            said
            for source, (read_at, said) in pasts.items()
            if now - read_at <= PARAMETERS.sources.get(source, CommandSource()).max_age + ROUNDING
        ]
        wanting = [said for said in young if said.weight > 0.0]
        if not wanting:
            assert (fused.linear, fused.angular) == (0.0, 0.0)
        else:
            assert abs(fused.linear) <= max(abs(said.linear) for said in wanting) + ROUNDING
            assert abs(fused.angular) <= max(abs(said.angular) for said in wanting) + ROUNDING


@given(steps)
def test_the_fused_speed_is_within_what_all_young_sources_and_the_numbers_allow(
    given_steps: list[tuple[float, MotionCmd | None]],
) -> None:
    fusion, now = Fusion(PARAMETERS), 0.0
    for elapsed, heard in given_steps:
        now += elapsed
        if heard is not None:
            fusion.hear(replace(heard, stamp=EPOCH + now - heard.stamp), now, EPOCH + now)
        fused = fusion.fuse(now, EPOCH + now)
        assert fused.linear <= least(fusion.young(now), "limit", PARAMETERS.linear)
        assert fused.linear >= -least(fusion.young(now), "back", PARAMETERS.linear)
        assert fused.angular <= least(fusion.young(now), "left", PARAMETERS.angular)
        assert fused.angular >= -least(fusion.young(now), "right", PARAMETERS.angular)
        assert fused.linear >= -PARAMETERS.linear
        assert abs(fused.angular) <= PARAMETERS.angular


@given(steps)
def test_without_a_young_required_source_nothing_moves(given_steps: list[tuple[float, MotionCmd | None]]) -> None:
    fusion, now = Fusion(PARAMETERS), 0.0
    for elapsed, heard in given_steps:
        now += elapsed
        if heard is not None:
            fusion.hear(replace(heard, stamp=EPOCH + now - heard.stamp), now, EPOCH + now)
        fused = fusion.fuse(now, EPOCH + now)
        if not any(one.command.source == "obstacle_avoiding" for one in fusion.young(now)):
            assert (fused.linear, fused.angular) == (0.0, 0.0)


@given(steps)
def test_speeds_grow_no_faster_than_the_accelerations_allow(given_steps: list[tuple[float, MotionCmd | None]]) -> None:
    fusion, now = Fusion(PARAMETERS), 0.0
    before = fusion.fuse(now, EPOCH)
    for elapsed, heard in given_steps:
        now += elapsed
        if heard is not None:
            fusion.hear(replace(heard, stamp=EPOCH + now - heard.stamp), now, EPOCH + now)
        fused = fusion.fuse(now, EPOCH + now)
        growth = abs(fused.linear) - abs(before.linear)
        assert growth <= PARAMETERS.acceleration * elapsed + ROUNDING
        assert abs(fused.angular) - abs(before.angular) <= PARAMETERS.angular_acceleration * elapsed + ROUNDING
        assert fused.linear * before.linear >= 0.0  # nothing is thrown from forward to backward
        before = fused


@given(steps)
@example([(0.25, MotionCmd(0.0, "goto", 1.0, 0.0, 0.5)), (0.25, None), (0.3, None)])
def test_without_limits_and_silence_the_robot_brakes_no_harder_than_the_numbers_say(
    given_steps: list[tuple[float, MotionCmd | None]],
) -> None:
    parameters = replace(PARAMETERS, sources={})
    fusion, now = Fusion(parameters), 0.0
    before = fusion.fuse(now, EPOCH)
    for elapsed, heard in given_steps:
        then, now = now, now + elapsed
        fusion.hear(MotionCmd(EPOCH + now, "steady", 0.0, 0.0, 0.0), now, EPOCH + now)
        if heard is not None:
            fusion.hear(
                replace(heard, stamp=EPOCH + now - heard.stamp, limit=None, back=None, left=None, right=None),
                now,
                EPOCH + now,
            )
        fused = fusion.fuse(now, EPOCH + now)
        if now - then <= MAX_GAP:  # as the fuser reckons it: three tenths of a second may be a rounding longer
            assert before.linear - fused.linear <= parameters.braking * elapsed + ROUNDING
            assert abs(before.angular - fused.angular) <= parameters.angular_braking * elapsed + ROUNDING
        before = fused


def test_who_has_not_fused_for_long_begins_from_rest() -> None:
    fusion = fed(command("obstacle_avoiding", 0.5))
    assert fusion.fuse(0.0, EPOCH).linear == 0.5
    fusion.hear(command("obstacle_avoiding", 0.5, stamp=EPOCH + 5.0), 5.0, EPOCH + 5.0)
    assert fusion.fuse(5.0, EPOCH + 5.0).linear == 0.0  # the base has stopped the robot long since


def test_the_fused_command_is_stamped_with_the_newest_reading() -> None:
    fusion = fed(command("goto", 0.4, stamp=EPOCH - 0.2), command("obstacle_avoiding", 0.0, stamp=EPOCH - 0.1))
    assert fusion.fuse(0.0, EPOCH).stamp == EPOCH - 0.1
    assert fusion.fuse(2.0, EPOCH + 2.0).stamp == EPOCH + 2.0

"""Agents that fail are started again with growing pauses, and are given up when that does not help."""

from dataclasses import replace

import pytest

from agents.platform import AgentName
from agents.services.restarts import DEFAULT, Restarts
from configs import ConfigError

CAMERA, BASE = AgentName("camera", "happy"), AgentName("base", "happy")


def pauses(restarts: Restarts, agent: AgentName, lives: list[float]) -> list[float | None]:
    """Let an agent fail after each of these lives, s."""
    now, found = 0.0, []
    for life in lives:
        now += life
        pause = restarts.failed(agent, now)
        found.append(pause)
        now += pause or 0.0
        restarts.attempted(agent, now)
    return found


def test_pauses_double_up_to_the_longest_and_then_the_agent_is_given_up() -> None:
    restarts = Restarts({"camera": {"attempts": 4, "first": 1.0, "longest": 3.0}})
    assert pauses(restarts, CAMERA, [0.0] * 5) == [1.0, 2.0, 3.0, 3.0, None]


def test_an_agent_that_lived_long_is_forgiven_and_one_that_flaps_is_not() -> None:
    restarts = Restarts({"*": {"attempts": 3, "first": 1.0, "healthy_after": 60.0}})
    assert pauses(restarts, CAMERA, [0.0, 59.0, 61.0, 59.0]) == [1.0, 2.0, 1.0, 2.0]
    assert pauses(restarts, BASE, [0.0, 59.0, 59.0, 59.0]) == [1.0, 2.0, 4.0, None]


def test_each_agent_is_counted_by_itself_and_forgotten_when_given_up_or_seen_to() -> None:
    restarts = Restarts({"camera": {"attempts": 1, "first": 1.0}})
    assert pauses(restarts, CAMERA, [0.0, 0.0, 0.0]) == [1.0, None, 1.0]
    assert restarts.attempts(CAMERA) == 1
    restarts.forget(CAMERA)
    assert (restarts.attempts(CAMERA), restarts.attempts(BASE)) == (0, 0)


def test_the_first_rule_that_matches_counts() -> None:
    rules = Restarts({"app-*": {"attempts": 0}, "*": {"attempts": -1}})
    assert rules.rule_of(AgentName("app-7", "lab")) == replace(DEFAULT, attempts=0)
    assert rules.rule_of(CAMERA).attempts == -1
    assert Restarts().rule_of(CAMERA) == DEFAULT
    assert rules.rules()["app-*"]["attempts"] == 0


def test_never_and_for_ever() -> None:
    rules = Restarts({"base": {"attempts": 0}, "camera": {"attempts": -1, "longest": 1.0}})
    assert pauses(rules, BASE, [0.0]) == [None]
    assert pauses(rules, CAMERA, [0.0] * 100)[-1] == 1.0


def test_a_rule_that_cannot_be_read_names_what_is_near() -> None:
    with pytest.raises(ConfigError, match=r"'camera': unknown key atempts; did you mean attempts\?"):
        Restarts({"camera": {"atempts": 2}})

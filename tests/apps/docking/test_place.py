"""Where a dock is: by numbers, or by its name on the map of the robot."""

from collections.abc import Mapping
from typing import Any

import pytest

from agents import NotThere, RobotError
from apps.docking.place import DockPlace
from geometry import Pose2D


class Localization:
    """In the place of a team whose robot is localized."""

    def __init__(self, heading: float | None = 1.5) -> None:
        self.heading = heading
        self.x = 1.0

    def ask(self, agent: str, request: str, /, **arguments: Any) -> Mapping[str, Any]:
        assert (agent, request, arguments) == ("localization@max", "goal", {"place": "Charger"})
        return {"x": self.x, "y": 2.0, "heading": self.heading}


class Nobody:
    """In the place of a team without a localization."""

    def ask(self, agent: str, request: str, /, **arguments: Any) -> Mapping[str, Any]:
        raise NotThere(f"nobody answers as {agent}")


def place(team: Any, given: Any) -> DockPlace:
    return DockPlace(team, "max", given)


@pytest.mark.parametrize("given", ["[1,2,0.5]", "1, 2, 0.5", [1, 2, 0.5], ["1", "2", "0.5"]])
def test_three_numbers_are_a_pose_in_odom(given: Any) -> None:
    assert place(Nobody(), given).pose() == Pose2D(1.0, 2.0, 0.5)


def test_a_name_is_looked_for_on_the_map_each_time_since_the_localization_improves() -> None:
    localization = Localization()
    charger = place(localization, "Charger")
    assert charger.pose() == Pose2D(1.0, 2.0, 1.5)
    localization.x = 1.1
    assert charger.pose() == Pose2D(1.1, 2.0, 1.5)


@pytest.mark.parametrize("given", ["", [], [1, 2], "[1,2]", "[1,2,nan]", [1, 2, "east"]])
def test_what_is_neither_a_pose_nor_a_name_is_refused(given: Any) -> None:
    with pytest.raises(RobotError, match="a dock is x, y and heading in m and rad"):
        place(Nobody(), given)


def test_a_name_without_a_localization_or_a_place_without_a_heading_is_refused_with_the_reason() -> None:
    with pytest.raises(RobotError, match="the dock 'Charger' is looked for on a map, but nobody answers"):
        place(Nobody(), "Charger").pose()
    with pytest.raises(RobotError, match="'Charger' has no heading on the map, so it is no dock"):
        place(Localization(heading=None), "Charger").pose()

"""The controller: shapes are formed, changed and left for a column; lost members and a silent leader."""

from dataclasses import replace
from pathlib import Path

import pytest

from apps.formation.settings import FormationSettings
from apps.formation.shapes import SHAPES, ShapeError
from geometry import Twist2D
from tests.apps.formation.toy import Toy

SETTINGS = FormationSettings.load()
WAIT = replace(SETTINGS, members=replace(SETTINGS.members, when_stopped="wait"))


@pytest.mark.parametrize("shape", SHAPES)
def test_every_shape_is_formed_and_kept(shape: str) -> None:
    toy = Toy(3, shape)
    toy.run(12.0)
    toy.run(3.0, Twist2D(0.2, 0.1))
    assert toy.off() < 0.06
    assert toy.told == []


def test_the_shape_changes_while_driving() -> None:
    toy = Toy(2, "triangle")
    toy.run(10.0)
    toy.formation.set_shape("line")
    toy.run(10.0)
    assert toy.off() < 0.06
    assert {round(y) for _, y in toy.orders.offsets.values()} == {1, -1}


def test_a_shape_that_does_not_exist_changes_nothing() -> None:
    toy = Toy(2, "triangle")
    with pytest.raises(ShapeError, match="did you mean line"):
        toy.formation.set_shape("lien")
    assert toy.formation.shape == "triangle"


def test_a_silent_leader_stops_all_followers_in_time() -> None:
    toy = Toy(2, "triangle")
    toy.run(10.0)
    assert any(twist != Twist2D() for twist in toy.orders.twists.values())
    toy.silent.add("leader")
    toy.run(SETTINGS.safety.silent_s + 0.2)
    assert set(toy.orders.twists.values()) == {Twist2D()}
    assert toy.told == ["leader, the leader, is silent; the followers stand"]
    toy.silent.clear()
    toy.run(10.0)
    assert toy.off() < 0.06
    assert toy.told[1:] == ["the followers drive on"]


def test_a_follower_that_was_never_heard_of_is_not_driven() -> None:
    toy = Toy(2, "column")
    toy.silent.add("robot-1")
    toy.run(10.0)
    assert toy.formation.members.active == ["robot-2"]
    assert toy.orders.twists["robot-1"] == Twist2D()


def test_a_lost_member_closes_the_gap_and_regains_its_place() -> None:
    toy = Toy(3, "line")
    toy.run(15.0)
    before = dict(toy.orders.offsets)
    lost = next(name for name, (_, y) in before.items() if y == -1.0)
    toy.silent.add(lost)
    toy.frozen.add(lost)
    toy.run(12.0, Twist2D(0.1, 0.0))
    assert lost not in toy.formation.members.active
    assert sorted(y for _, y in toy.orders.offsets.values()) == [-1.0, 1.0]
    toy.silent.clear()
    toy.frozen.clear()
    toy.run(18.0, Twist2D(0.1, 0.0))
    assert dict(toy.orders.offsets) == before
    assert toy.off() < 0.06
    assert toy.told == [f"{lost} is silent; the others close the gap", f"{lost} is back"]


def test_a_member_whose_sonar_is_silent_stands_and_is_told_as_lost_until_it_hears_again() -> None:
    toy = Toy(2, "triangle")
    toy.run(12.0)
    toy.blind.add("robot-1")
    toy.run(1.0)
    assert toy.orders.twists["robot-1"] == Twist2D()
    assert toy.orders.twists["robot-2"] != Twist2D()
    assert [member.name for member in toy.formation.members.lost] == ["robot-1"]
    toy.blind.clear()
    toy.run(15.0, Twist2D(0.1, 0.0))
    assert toy.told == ["robot-1 has a silent sonar; the others close the gap", "robot-1 is back"]
    assert toy.off() < 0.06


def test_a_leader_whose_sonar_is_silent_is_followed() -> None:
    toy = Toy(2, "triangle")
    toy.blind.add("leader")
    toy.run(12.0)
    assert toy.told == []
    assert toy.off() < 0.06


@pytest.mark.parametrize(("settings", "others_drive"), [(SETTINGS, True), (WAIT, False)])
def test_a_stopped_member_is_left_behind_or_waited_for(settings: FormationSettings, others_drive: bool) -> None:
    toy = Toy(2, "column", settings)
    toy.run(10.0)
    toy.frozen.add("robot-1")
    toy.run(SETTINGS.members.stuck_s + 4.0)
    assert toy.formation.members.active == ["robot-2"]
    assert (toy.orders.twists["robot-2"] != Twist2D()) is others_drive
    assert bool(toy.formation.waits_for) is not others_drive
    toy.frozen.clear()
    toy.run(15.0, Twist2D())
    assert toy.formation.members.active == ["robot-1", "robot-2"]
    assert toy.off() < 0.1


def test_a_member_that_refuses_is_told_with_its_reason_and_comes_back() -> None:
    toy = Toy(2, "triangle")
    toy.run(5.0)
    toy.formation.refused("robot-1", "the e-stop is pressed")
    toy.run(1.0)
    assert toy.told == ["robot-1 refuses to drive: the e-stop is pressed; the others close the gap"]
    assert toy.formation.status["lost"] == {"robot-1": "refuses to drive: the e-stop is pressed"}
    toy.formation.refused("robot-1", "")
    toy.run(5.0)
    assert toy.told[1:] == ["robot-1 is back"]


def test_a_door_makes_a_column_and_the_shape_is_formed_again() -> None:
    toy = Toy(2, "triangle")
    toy.walls = [(3.0, side * (0.45 + number / 10)) for number in range(8) for side in (1, -1)]
    toy.run(30.0)
    assert toy.told == ["too narrow for the triangle: forming a column", "room again: forming the triangle"]
    assert toy.nearest_wall > SETTINGS.safety.radius_m
    assert toy.off() < 0.06


def test_followers_keep_apart_when_the_leader_turns_on_the_spot() -> None:
    toy = Toy(2, "triangle")
    toy.run(5.0)
    toy.run(6.0, Twist2D(0.0, 0.8))
    assert toy.nearest > 2 * SETTINGS.safety.radius_m


def test_a_file_with_offsets_is_read_once(tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text("offsets_m = [[-1.0, 0.5], [-1.0, -0.5]]")
    toy = Toy(2, str(file))
    file.unlink()
    toy.run(8.0)
    assert toy.off() < 0.06

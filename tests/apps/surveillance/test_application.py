"""The application's arguments, and the report that it writes."""

from pathlib import Path
from typing import Any

import pytest

from agents import RobotError
from apps.surveillance import application
from apps.surveillance.application import main, status, write_now
from apps.surveillance.record import NightRecord
from apps.surveillance.report import write_report
from apps.surveillance.settings import SurveillanceSettings
from configs import ConfigError
from tests.apps.surveillance.building import ROOMS, building_map, map_file

PIXEL = b"\x89PNG\r\n\x1a\n and so on"


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"map": "none.map"}, "none.map"),
        ({"rooms": "Lab"}, "rooms by name need map=FILE, whose goals they are"),
        ({"rooms": {"Lab": [1]}}, r"the place of Lab is \[1\]; expected \[x, y\] in m"),
        ({"rooms": "world:atlantis"}, "atlantis"),
        ({"rooms": "world:empty"}, "the world empty has no places"),
        ({"minutes": -1.0}, "minutes must be 0 or more, not -1"),
        ({"settings": "none.toml"}, "none.toml"),
        ({"starts": {"happy": [1, 1, 0]}}, "starts= needs map=FILE"),
    ],
)
def test_bad_input_is_told_before_anything_begins(given: dict[str, Any], told: str) -> None:
    team: Any = None
    with pytest.raises(RobotError, match=told):
        main(team, **given)


def test_a_room_that_the_map_does_not_have_gets_a_suggestion(tmp_path: Path) -> None:
    team: Any = None
    with pytest.raises(RobotError, match=r'the map has no goal "Soth" \(did you mean South\?\)'):
        main(team, map=str(map_file(tmp_path)), rooms="North, Soth")


def test_settings_go_through_a_message_unchanged(tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text('rooms = ["South", "North"]\n[patrol]\ndwell_s = 1.5\n')
    settings = SurveillanceSettings.load(file)
    assert (settings.rooms, settings.patrol.dwell_s) == (("South", "North"), 1.5)
    assert SurveillanceSettings.of_table(settings.to_table()) == settings
    with pytest.raises(ConfigError):
        SurveillanceSettings.of_table({"rooms": []})


def night() -> NightRecord:
    """Three looks at the status, with an alarm before the last."""
    record = NightRecord()
    for now in (0.0, 1.0, 2.0):
        rooms = {
            name: {"x": x, "y": y, "robot": "happy", "neglect": now, "longest": now, "visits": int(now)}
            for name, (x, y) in ROOMS.items()
        }
        alarm = {"number": 1, "ago": 0.5, "robot": "happy", "sensor": "laser", "x": 3.0, "y": 1.6, "room": "South"}
        robots = {"happy": {"pose": [1.0 + now, 1.0, 0.0], "serves": True, "does": "drives"}}
        status = {"robots": robots, "rooms": rooms, "longest": now, "alarms": [alarm] if now == 2.0 else []}
        record.add(now, status)
    record.told.append("2 s: alarm 1: happy sees an intruder")
    record.pictures[1] = [PIXEL]
    return record


def test_the_report_has_visits_neglect_alarms_and_pictures(tmp_path: Path) -> None:
    page = write_report(tmp_path / "report", night(), building_map())
    text = page.read_text()
    assert "1 robots patrolled 4 rooms for 0.0 min: 8 visits, longest neglect 2 s, 1 alarms." in text
    assert "| Far | 2 | 2 | 2 | happy |" in text
    assert "| 1 | 2 | happy | laser | (3.0, 1.6) | South |" in text
    assert "![Alarm 1](alarm-1-1.png)" in text
    assert "- 2 s: alarm 1: happy sees an intruder" in text
    assert (page.parent / "alarm-1-1.png").read_bytes() == PIXEL
    assert {each.name for each in page.parent.iterdir()} == {"report.md", "floor.png", "neglect.png", "alarm-1-1.png"}


def test_a_night_of_which_every_second_look_is_kept_still_has_all_rooms(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("apps.surveillance.record._MOST", 2)
    record = night()
    assert record.times == [0.0, 2.0]
    assert {len(each) for each in record.neglect.values()} == {2}


def test_requests_tell_the_status_and_write_the_report_so_far(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(application, "_running", [])
    for ask in (status, write_now):
        with pytest.raises(RobotError, match="the patrol has not begun yet"):
            ask()
    monkeypatch.setattr(application, "_running", [night()])
    monkeypatch.setattr("apps.surveillance.report.missing", lambda *extras: ["matplotlib"])
    assert status()["longest"] == 2.0
    page = write_now(str(tmp_path / "so-far"))["report"]
    assert "2 s: alarm 1" in Path(page).read_text()
    (tmp_path / "file").touch()
    with pytest.raises(RobotError, match="the report cannot be written to"):
        write_now(str(tmp_path / "file" / "below"))

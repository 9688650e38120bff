"""The application as people run it: robots patrol, an intruder raises an alarm, and all stop when it is lost."""

import signal
from pathlib import Path
from typing import Any

from apps.surveillance.patrol_manager import NAME
from bus import Sample
from tests.acromovi.team.running import RunningTeam, running
from tests.apps.on_a_team import application, wait_until_stand
from tests.shown import files
from tests.waiting import wait_until


class Night:
    """What the manager of the patrol publishes."""

    def __init__(self, team: RunningTeam) -> None:
        self._latest: dict[str, Any] = {"robots": {}, "rooms": {}, "alarms": []}
        team.bus.subscribe(f"apps/agents/{NAME}/results", self._take)

    @property
    def has_visits(self) -> bool:
        return any(each["visits"] for each in self._latest["rooms"].values())

    @property
    def drives(self) -> bool:
        return any(each["serves"] and "drives to" in str(each["does"]) for each in self._latest["robots"].values())

    @property
    def alarms(self) -> list[dict[str, Any]]:
        return list(self._latest["alarms"])

    def forget(self) -> None:
        self._latest = {**self._latest, "robots": {}}

    def _take(self, sample: Sample) -> None:
        self._latest = sample.decoded()


def test_an_intruder_raises_an_alarm_and_robots_stop_when_the_application_freezes_or_is_killed(tmp_path: Path) -> None:
    file, plan = tmp_path / "night.toml", tmp_path / "night.map"
    plan.write_text(files("surveillance", "text")[0])
    file.write_text(files("surveillance", "toml")[0].replace('"night.map"', f'"{plan}"'))
    words = ("surveillance", f"map={plan}", f"starts={file}")
    with running(str(file)) as team, application(team, tmp_path, words, ["happy"], "promote") as process:
        night = Night(team)
        wait_until(lambda: night.has_visits, "a room is visited")
        team.emulator().ask("add", model="p3dx-sh", name="stranger", x=3.2, y=2.3)
        wait_until(lambda: bool(night.alarms), "a robot sees the intruder")
        assert (night.alarms[0]["sensor"], night.alarms[0]["room"]) == ("laser", "South")
        wait_until(lambda: night.drives, "a robot drives on")
        process.send_signal(signal.SIGSTOP)
        wait_until_stand(team, ["happy", "doc"])
        night.forget()
        process.send_signal(signal.SIGCONT)
        wait_until(lambda: night.drives, "a robot drives again")
        process.kill()
        wait_until_stand(team, ["happy", "doc"])

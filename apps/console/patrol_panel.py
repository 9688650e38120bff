"""The panel of a patrol beside the map: rooms with their neglect, and alarms with their pictures."""

import time

from nicegui import ui
from nicegui.element import Element

from apps.console.data_view import DataTable
from apps.console.page import panel
from apps.console.patrol import Patrol, PatrolAlarm
from apps.console.program import Console


class PatrolPanel:
    """Shown while there is a patrol."""

    def __init__(self, console: Console) -> None:
        """Add it to the page."""
        self._console = console
        self._alarms: list[tuple[object, ...]] | None = None
        with panel("Patrol") as self._box:
            self._words = ui.label().props('role="status"')
            self._rooms = DataTable(("Room", "Robot", "Not visited for", "Visits"), "no room")
            with ui.element("h3"):
                ui.label("Alarms")
            self._list = ui.element("ul").classes("c-plain c-alarms")
        self._box.set_visibility(False)

    def refresh(self) -> None:
        """Show the patrol as it is now."""
        patrol = self._console.map.patrol.patrol
        self._box.set_visibility(patrol is not None)
        if patrol is None:
            return
        self._words.text = _words(patrol)
        rows = sorted(patrol.rooms, key=lambda room: -room.neglect)
        self._rooms.show([[room.name, room.robot, f"{room.neglect:.0f} s", str(room.visits)] for room in rows])
        shown: list[tuple[object, ...]] = [
            (each.number, each.room, each.follower, each.is_seen, each.picture) for each in patrol.alarms
        ]
        if shown != self._alarms:
            self._alarms = shown
            self._list.clear()
            with self._list:
                if not patrol.alarms:
                    ui.label("no intruder has been seen").classes("c-quiet")
                for alarm in reversed(patrol.alarms):
                    _add(alarm)


def _words(patrol: Patrol) -> str:
    """Return what the robots do, and the longest neglect."""
    does = [f"{robot} {what}" for robot, what in sorted(patrol.does.items())]
    return "; ".join([*does, f"longest time without a visit {patrol.longest:.0f} s"])


def _add(alarm: PatrolAlarm) -> None:
    """Add an alarm to the list."""
    with ui.element("li"):
        clock = time.strftime("%H:%M:%S", time.localtime(alarm.at))
        where = f" near {alarm.room}" if alarm.room else ""
        words = f"{clock} alarm {alarm.number}{where}: seen by {alarm.robot} ({alarm.sensor})"
        if alarm.follower:
            words += f", {alarm.follower} follows"
        ui.label(words).classes("c-alarmed" if alarm.is_seen else "")
        if alarm.picture:
            image = Element("img")
            image._props["src"] = alarm.picture
            image._props["alt"] = f"what {alarm.robot} saw at alarm {alarm.number}"

"""The panel of a robot's buzzer or sounds."""

from nicegui import ui

from apps.console.page import disable_if_looking, panel
from apps.console.program import Console
from apps.console.visits import Visit
from bus import keys

_TUNES = {"Beep": [[72, 0.2]], "Rising": [[60, 0.15], [64, 0.3]], "Falling": [[64, 0.15], [60, 0.3]]}
_MOST_SOUNDS = 40


class SoundPanel:
    """Plays notes, and the sounds that the robot has."""

    def __init__(self, console: Console, visit: Visit) -> None:
        """Build it."""
        self._console, self._visit = console, visit
        rows = console.robots.robots[visit.robot].elements["sound"].get("sounds")
        sounds = {row["number"]: str(row["name"]) for row in rows[:_MOST_SOUNDS]} if isinstance(rows, list) else {}
        with panel("Sound"), ui.row().classes("rv-row") as row:
            for name, notes in _TUNES.items():
                ui.button(name, on_click=lambda notes=notes: self._play(notes=notes)).props("outline dense no-caps")
            ui.button("Mute", on_click=lambda: self._play(on=False)).props("flat dense no-caps")
            if sounds:
                chosen = ui.select(sounds, label="Sound", on_change=lambda event: self._play(number=event.value))
                chosen.classes("rv-name")
        disable_if_looking(visit, row)

    def refresh(self) -> None:
        """Nothing is reported of sounds."""

    async def _play(self, **arguments: object) -> None:
        why = await self._console.command(self._visit.robot, keys.SOUND, **arguments)
        self._console.say(self._visit, f"sound: {why or 'played'}")

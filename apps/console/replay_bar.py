"""The bar of a replay, on every page: play, pause, seek, speed."""

import time
from typing import TYPE_CHECKING

from nicegui import ui
from nicegui.element import Element
from nicegui.events import GenericEventArguments

from apps.console.program import Console

if TYPE_CHECKING:
    from apps.console.replay import Replay  # of the extra `recorder`

_REFRESH = 0.25  # s
_MOST_MARKS = 400  # events marked beside the position


class _ReplayControls(Element, component="replay_bar.js"):
    """Events: `toggle`; `seek` {elapsed}, s since the first message; `speed` {speed}."""

    def __init__(self, replay: "Replay") -> None:
        super().__init__()
        self._props["speeds"] = list(replay.SPEEDS)
        self._props["duration"] = replay.duration
        self._props["words"] = replay.words

    def show(self, **props: object) -> None:
        """Change properties; what is as it was is not sent."""
        for name, value in props.items():
            if self._props.get(name) != value:
                self._props[name] = value


class ReplayBar:
    """Plays the recording for all pages of the console."""

    def __init__(self, console: Console, replay: "Replay") -> None:
        """Add it to the page."""
        self._console, self._replay = console, replay
        self._marked: object = None
        self._controls = _ReplayControls(replay)
        self._controls.on("toggle", self._toggle)
        self._controls.on("seek", self._seek)
        self._controls.on("speed", self._change_speed)
        if replay.notes:
            ui.label("; ".join(replay.notes)).classes("c-alarmed c-note").props('role="status"')
        self._refresh()
        ui.timer(_REFRESH, self._refresh)

    def _refresh(self) -> None:
        replay = self._replay
        self._controls.show(
            elapsed=round(replay.elapsed, 2),
            paused=replay.is_paused,
            speed=replay.speed,
            clock=time.strftime("%Y-%m-%d %H:%M:%S", time.localtime(replay.now())),
        )
        if self._marked is not replay.timeline:
            self._marked = replay.timeline
            self._controls.show(marks=self._marks())

    def _marks(self) -> list[tuple[float, str]]:
        """Return the positions of events, parts of the duration, and their kinds."""
        duration = max(self._replay.duration, 1e-9)
        events = self._replay.timeline.events
        few = events[:: max(1, -(-len(events) // _MOST_MARKS))]
        return [(round(self._replay.position_of(event.time) / duration, 4), event.kind) for event in few]

    def _toggle(self) -> None:
        if self._replay.is_paused:
            self._replay.play()
        else:
            self._replay.pause()
        self._refresh()

    async def _seek(self, event: GenericEventArguments) -> None:
        elapsed = event.args.get("elapsed")
        if isinstance(elapsed, int | float):
            await self._console.seek(float(elapsed))
            self._refresh()

    def _change_speed(self, event: GenericEventArguments) -> None:
        if event.args.get("speed") in self._replay.SPEEDS:
            self._replay.set_speed(float(event.args["speed"]))
            self._refresh()

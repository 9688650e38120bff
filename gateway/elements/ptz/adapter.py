"""The camera head on the bus."""

from collections.abc import Iterable, Mapping
from typing import Any

from bus import keys
from bus.keys import Topic, frame
from bus.messages import PanTiltZoom, header
from gateway.commands import Arguments, CommandRow
from gateway.elements.adapter import BusAdapter
from gateway.elements.ptz.element import PtzElement
from gateway.errors import CommandRefused
from gateway.events import HeadSeen


class _PtzAdapter(BusAdapter[HeadSeen]):
    """`<robot>/ptz` and `command/ptz`."""

    name = "ptz"
    element = PtzElement
    streams = (keys.PTZ,)
    events = (HeadSeen,)

    def messages(self, event: HeadSeen, stamp: int) -> Iterable[tuple[Topic, object]]:
        """Return one message for each report of the head."""
        yield keys.PTZ, PanTiltZoom(header(stamp, frame(self._robot, "ptz")), *event)

    def describe(self) -> Mapping[str, Any]:
        """Return model, limits and widest horizontal field of view."""
        model = self._driver.lookup(PtzElement).model
        return {
            "model": model.name,
            "limits": {"pan": model.pan.limits, "tilt": model.tilt.limits, "zoom": (1.0, model.lens.ratio)},
            "field_of_view": model.lens.field_of_view(1.0),
        }

    def _look(self, arguments: Arguments, now: float) -> None:
        head = self._driver.element(PtzElement, now)
        what = arguments.get("do", "look")
        if what == "stop":
            head.stop(now)
        elif what == "look":
            head.look(arguments.get("pan"), arguments.get("tilt"), arguments.get("zoom"), now)
        else:
            raise CommandRefused(f"a camera head cannot {what!r}; use stop, or pan, tilt or zoom")

    def _duration(self, arguments: Arguments, now: float) -> float:
        if arguments.get("do", "look") != "look":
            return 0.0
        return self._driver.lookup(PtzElement).duration(
            arguments.get("pan"), arguments.get("tilt"), arguments.get("zoom")
        )

    commands = (
        CommandRow(
            keys.LOOK,
            {},
            _look,
            name,
            may_take={"pan": float, "tilt": float, "zoom": float, "do": str},
            duration=_duration,
        ),
    )


ADAPTERS = (_PtzAdapter,)

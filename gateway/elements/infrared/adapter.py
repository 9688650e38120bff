"""The infrared sensors on the bus."""

from collections.abc import Iterable
from math import inf

from bus import keys
from bus.keys import Topic, frame
from bus.messages import Header, Range, RangeArray, TransformStamped, header, placed
from gateway.elements.adapter import BusAdapter
from gateway.elements.infrared.element import InfraredElement
from gateway.events import Event, InfraredSeen

THRESHOLD = 0.0
"""m; each frame lies where its sensor sees something, since a switch measures no distance."""


class InfraredAdapter(BusAdapter):
    """`<robot>/ir`: each sensor is a switch. REP 117: -inf where something is near, and +inf where nothing is."""

    name = "ir"
    element = InfraredElement
    streams = (keys.IR,)

    def messages(self, event: Event, stamp: int) -> Iterable[tuple[Topic, object]]:
        """One with every IOpac."""
        if isinstance(event, InfraredSeen):
            base = header(stamp, frame(self._robot, "base_link"))
            ranges = [self._range(base, number, near) for number, near in event.near]
            yield keys.IR, RangeArray(base, ranges)

    def transforms(self, stamp: int) -> Iterable[TransformStamped]:
        """Where the sensors look, as far as the model says so."""
        base = header(stamp, frame(self._robot, "base_link"))
        return [placed(base, self._frame(sensor.number), sensor.x, sensor.y, 0.0) for sensor in self._model.irs]

    def _frame(self, number: int) -> str:
        return frame(self._robot, f"ir_{number}")

    def _range(self, base: Header, number: int, near: bool) -> Range:
        return Range(
            header=Header(stamp=base.stamp, frame_id=self._frame(number)),
            radiation_type=Range.INFRARED,
            field_of_view=0.0,
            min_range=THRESHOLD,
            max_range=THRESHOLD,
            range=-inf if near else inf,
            variance=0.0,
        )


ADAPTERS = (InfraredAdapter,)

"""The infrared sensors on the bus."""

from collections.abc import Iterable
from math import inf

from bus import keys
from bus.keys import Topic, frame
from bus.messages import Header, Range, RangeArray, TransformStamped, header, placed
from gateway.elements.adapter import BusAdapter
from gateway.elements.infrared.element import InfraredElement
from gateway.events import InfraredSeen

THRESHOLD = 0.0
"""m; each frame lies where its sensor sees something, since a switch measures no distance."""


class _InfraredAdapter(BusAdapter[InfraredSeen]):
    """`<robot>/ir`: each sensor is a switch. REP 117: -inf where something is near, and +inf where nothing is."""

    name = "ir"
    element = InfraredElement
    streams = (keys.IR,)
    events = (InfraredSeen,)

    def messages(self, event: InfraredSeen, stamp: int) -> Iterable[tuple[Topic, object]]:
        """Return one message for each reading of the sensors."""
        base = header(stamp, frame(self._robot, "base_link"))
        ranges = [self._range(base, number, near) for number, near in event.near]
        yield keys.IR, RangeArray(base, ranges)

    def transforms(self, stamp: int) -> Iterable[TransformStamped]:
        """Return the poses of the sensors, as far as the model has them."""
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


ADAPTERS = (_InfraredAdapter,)

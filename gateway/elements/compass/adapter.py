"""The compass on the bus."""

from collections.abc import Iterable

from bus import keys
from bus.keys import Topic, frame
from bus.messages import Compass, Vector3, header
from gateway.elements.adapter import BusAdapter
from gateway.elements.compass.element import CompassElement
from gateway.events import CompassSeen


class _CompassAdapter(BusAdapter[CompassSeen]):
    """`<robot>/compass`."""

    name = "compass"
    element = CompassElement
    streams = (keys.COMPASS,)
    events = (CompassSeen,)

    def messages(self, event: CompassSeen, stamp: int) -> Iterable[tuple[Topic, object]]:
        """Return one message for each packet."""
        report = event.report
        message = Compass(
            header(stamp, frame(self._robot, "base_link")),
            heading=event.heading,
            pitch=report.pitch,
            roll=report.roll,
            magnetic_field=Vector3(x=report.field_x, y=report.field_y, z=report.field_z),
            temperature=report.temperature,
            errors=report.error_bits,
        )
        yield keys.COMPASS, message


ADAPTERS = (_CompassAdapter,)

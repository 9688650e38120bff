"""The agent of the infrared sensors."""

from collections.abc import Mapping
from math import inf
from typing import Any, ClassVar

from agents.components.component import ElementAgent, known
from bus import keys
from bus.messages import RangeArray


class InfraredAgent(ElementAgent):
    """Switches rather than rulers: each frame lies where its sensor sees something."""

    source = keys.IR
    results: ClassVar[Mapping[str, str]] = {
        "ranges": "m by the number of the sensor: 0 where it sees something, null where not",
        "nearest": "m, null where none sees anything",
    }

    def result(self, message: RangeArray) -> dict[str, Any]:
        """What is near."""
        ranges = {
            each.header.frame_id.rpartition("_")[2]: known(each.min_range if each.range == -inf else each.range)
            for each in message.ranges
        }
        return {"ranges": ranges, "nearest": min((near for near in ranges.values() if near is not None), default=None)}

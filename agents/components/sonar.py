"""The agent of the sonar discs."""

from collections.abc import Mapping
from math import atan2, cos, sin
from typing import Any, ClassVar

from agents.components.component import ElementAgent, known
from agents.platform import AgentName, request
from bus import keys
from bus.messages import NS_PER_S, RangeArray, stamp_ns

MEMORY = 1.0
"""Seconds for which a disc's range stands; each packet brings those of a few discs only."""


class SonarAgent(ElementAgent):
    """All discs together, though they take turns. `bearing` is where the nearest echo is, seen from the robot."""

    source = keys.SONAR
    eager = True
    results: ClassVar[Mapping[str, str]] = {
        "ranges": "m by the number of the disc, null where no echo came",
        "nearest": "m, null where none came at all",
        "bearing": "rad in base_link, of the nearest",
    }

    def __init__(self, name: AgentName | str, properties: Mapping[str, Any] | None = None) -> None:
        super().__init__(name, properties)
        self._ranges: dict[int, tuple[float, float | None]] = {}  # stamp in s, and m

    @classmethod
    def properties_of(cls, robot: Mapping[str, Any], element: Mapping[str, Any]) -> dict[str, Any]:
        """Where the discs are besides."""
        return {**super().properties_of(robot, element), "discs": robot["geometry"]["sonar"]}

    @request("power", agrees_itself=True)
    async def power(self, on: bool) -> dict[str, Any]:
        """Switch the sonar on or off."""
        return await self.command(keys.SONAR_POWER, on=on)

    def result(self, message: RangeArray) -> dict[str, Any]:
        """The ranges of the last second."""
        now = stamp_ns(message.header) / NS_PER_S
        self._ranges |= {_number(each.header.frame_id): (now, known(each.range)) for each in message.ranges}
        self._ranges = {disc: seen for disc, seen in self._ranges.items() if abs(now - seen[0]) <= MEMORY}
        echoes = [(distance, disc) for disc, (_, distance) in self._ranges.items() if distance is not None]
        nearest, disc = min(echoes, default=(None, None))
        return {
            "ranges": {str(disc): self._ranges[disc][1] for disc in sorted(self._ranges)},
            "nearest": nearest,
            "bearing": None if nearest is None or disc is None else self._bearing(disc, nearest),
        }

    def _bearing(self, number: int, distance: float) -> float | None:
        """Of an echo on the axis of a disc."""
        for disc in self.properties.get("discs", []):
            if disc["number"] == number:
                x, y, heading = disc["x"], disc["y"], disc["heading"]
                return known(atan2(y + distance * sin(heading), x + distance * cos(heading)))
        return None


def _number(frame_id: str) -> int:
    """Of the disc with this frame, `happy/sonar_3`."""
    return int(frame_id.rpartition("_")[2])

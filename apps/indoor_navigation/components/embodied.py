"""Components that need the size of the robot and its deceleration."""

import asyncio
import logging
from collections.abc import Mapping
from typing import Any

from agents.platform import OneShot, Restart
from apps.indoor_navigation.algorithms.outline import Outline
from apps.indoor_navigation.component import Component
from bus import BusUnavailable, Refused

RETRY_PERIOD = 0.5  # s between two queries until the base answers
SURE = 0.88  # part of the commanded deceleration that a robot reaches at least

log = logging.getLogger("navigation")


class Embodied(Component):
    """Queries the base for the robot's outline and deceleration until it answers; does nothing before."""

    outline: Outline | None = None

    async def setup(self) -> None:
        """Begin to query the base."""
        self.add(OneShot(self._know_body), Restart())

    def embody(self, outline: Outline, deceleration: float) -> None:
        """Begin with this outline and the deceleration that the robot reaches at least, m/s²."""

    async def _know_body(self) -> None:
        while self.outline is None:
            try:
                robot: Mapping[str, Any] = await self.ask("robot")
                outline, deceleration = Outline.of(robot), SURE * float(robot["limits"]["deceleration"])
            except BusUnavailable:
                raise
            except (TimeoutError, Refused, LookupError, TypeError, ValueError) as err:
                log.info("%s: the base of %s has not described the robot yet: %r", self.name, self.robot, err)
                await asyncio.sleep(RETRY_PERIOD)
            else:
                self.embody(outline, deceleration)
                self.outline = outline

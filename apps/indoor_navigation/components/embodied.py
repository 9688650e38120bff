"""A component that has to know how large the robot is, and how hard it brakes."""

import asyncio
import logging
from collections.abc import Mapping
from typing import Any

from agents.platform import OneShot, Restart
from apps.indoor_navigation.algorithms.outline import Outline
from apps.indoor_navigation.component import Component
from bus import BusUnavailable, Refused

ASK_AGAIN = 0.5  # s
SURE = 0.88  # of how hard the robot is told to brake, what it surely does

log = logging.getLogger("navigation")


class Embodied(Component):
    """Asks the base what the robot is, until it is told. Without that, it does nothing."""

    outline: Outline | None = None

    async def setup(self) -> None:
        """Ask."""
        self.add(OneShot(self._know_body), Restart())

    def embody(self, outline: Outline, deceleration: float) -> None:
        """Begin: this is the robot's outline, and so hard it surely brakes, m/s²."""

    async def _know_body(self) -> None:
        while self.outline is None:
            try:
                robot: Mapping[str, Any] = await self.ask("robot")
                outline, deceleration = Outline.of(robot), SURE * float(robot["limits"]["deceleration"])
            except BusUnavailable:
                raise
            except (TimeoutError, Refused, LookupError, TypeError, ValueError) as err:
                log.info("%s: nobody has said yet what %s is: %r", self.name, self.robot, err)
                await asyncio.sleep(ASK_AGAIN)
            else:
                self.embody(outline, deceleration)
                self.outline = outline

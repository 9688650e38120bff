"""A component that has to know how large the robot is."""

import asyncio
import logging

from agents.platform import OneShot, Restart
from apps.indoor_navigation.algorithms.outline import Outline
from apps.indoor_navigation.component import Component
from bus import BusUnavailable, Refused

ASK_AGAIN = 0.5  # s

log = logging.getLogger("navigation")


class Embodied(Component):
    """Asks the base for the robot's outline, until it is told. Without it, it does nothing."""

    outline: Outline | None = None

    async def setup(self) -> None:
        """Ask."""
        self.add(OneShot(self._know_body), Restart())

    def embody(self, outline: Outline) -> None:
        """Begin: this is the robot's outline."""

    async def _know_body(self) -> None:
        while self.outline is None:
            try:
                outline = Outline.of(await self.ask("robot"))
            except BusUnavailable:
                raise
            except (TimeoutError, Refused, LookupError, TypeError, ValueError) as err:
                log.info("%s: nobody has said yet how large %s is: %r", self.name, self.robot, err)
                await asyncio.sleep(ASK_AGAIN)
            else:
                self.embody(outline)
                self.outline = outline

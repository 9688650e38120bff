"""Components that need the size of the robot and its deceleration."""

import asyncio
import logging
from collections.abc import Mapping
from typing import Any

from agents.platform import Cyclic, Restart
from apps.indoor_navigation.algorithms.outline import Outline
from apps.indoor_navigation.component import Component
from bus import BusUnavailable, Refused

RETRY_PERIOD = 0.5  # s between two queries until the base answers
QUERY_PERIOD = 1.0  # s between two queries after that, while the component is awake
SURE = 0.88  # part of the commanded deceleration that a robot reaches at least

log = logging.getLogger("navigation")


class Embodied(Component):
    """Queries the base for the robot's outline and deceleration periodically; does nothing before the first answer.

    The robot may be replaced, or its gateway be restarted with other settings.
    """

    outline: Outline | None = None
    _deceleration = 0.0

    async def setup(self) -> None:
        """Begin to query the base."""
        self.add(Cyclic(self._know_body), Restart())

    def embody(self, outline: Outline, deceleration: float) -> None:
        """Begin with this outline and the deceleration that the robot reaches at least, m/s²; again if they change."""

    async def _know_body(self) -> None:
        if self.outline is not None:
            await self.awake()
        try:
            robot: Mapping[str, Any] = await self.ask("robot")
            outline, deceleration = Outline.of(robot), SURE * float(robot["limits"]["deceleration"])
        except BusUnavailable:
            raise
        except (TimeoutError, Refused, LookupError, TypeError, ValueError) as err:
            log.info("%s: the base of %s does not describe the robot: %r", self.name, self.robot, err)
        else:
            if (outline, deceleration) != (self.outline, self._deceleration):
                self.embody(outline, deceleration)
                self.outline, self._deceleration = outline, deceleration
        await asyncio.sleep(RETRY_PERIOD if self.outline is None else QUERY_PERIOD)

"""The agent of a pan-tilt-zoom head."""

from collections.abc import Mapping
from typing import Any, ClassVar

from agents.components.component import known
from agents.components.motions import MotionGoal, Phase
from agents.components.moving import MovingElementAgent, Result
from agents.platform import request
from bus import keys

TOLERANCES = {"pan": 0.01, "tilt": 0.01}
"""rad; more than a count of any head."""
ZOOM_TOLERANCE = 0.03
"""Likewise of the magnification, as a part of it."""
LONGEST = 40.0
"""Seconds, in which a head may have to find its zero first."""
STOPPING_TIME = 5.0
AT_ONCE = 0.0
"""Seconds that a report must last: the gateway knows whether it has told the head to move."""


class PtzAgent(MovingElementAgent):
    """`ptz@happy`."""

    source = keys.PTZ
    orders = keys.LOOK
    results: ClassVar[Mapping[str, str]] = {
        "pan": "rad, to the left",
        "tilt": "rad, up",
        "zoom": "magnification, 1 at the widest",
        "moving": "it turns or zooms",
    }

    def result(self, message: Any) -> Mapping[str, Any]:
        """Return direction and magnification."""
        place = {axis: known(getattr(message, axis)) for axis in ("pan", "tilt", "zoom")}
        return {**place, "moving": bool(message.moving)}

    @request("look", agrees_itself=True)
    async def look(
        self,
        pan: float | None = None,
        tilt: float | None = None,
        zoom: float | None = None,
        wait: bool = True,
        token: str = "",
    ) -> dict[str, Any]:
        """Turn the head: rad to the left, rad up, magnification; an argument that is left out stays as it is."""
        axes = {"pan": pan, "tilt": tilt, "zoom": zoom}
        return await self._look("look", {axis: place for axis, place in axes.items() if place is not None}, wait, token)

    @request("centre", agrees_itself=True)
    async def centre(self, wait: bool = True, token: str = "") -> dict[str, Any]:
        """Look straight ahead; the magnification stays as it is."""
        return await self._look("centre", {"pan": 0.0, "tilt": 0.0}, wait, token)

    @request("stop", agrees_itself=True)
    async def stop(self, token: str = "") -> dict[str, Any]:
        """Stop the head."""
        goal = MotionGoal(f"{self.element} stop", ("pan", "tilt", "zoom"), _is_still, STOPPING_TIME, hold=AT_ONCE)
        return await self.carry_out(goal, token, do="stop")

    async def _look(self, what: str, places: Mapping[str, float], wait: bool, token: str) -> dict[str, Any]:
        def judge(result: Result) -> Phase:
            if result["moving"]:
                return Phase.MOVING
            return Phase.ARRIVED if all(_is_at(result, axis, places[axis]) for axis in places) else Phase.RESTING

        goal = MotionGoal(f"{self.element} {what}", tuple(places), judge, LONGEST, hold=AT_ONCE)
        return await self.carry_out(goal, token, wait, **places)


def _is_at(result: Result, axis: str, place: float) -> bool:
    seen = result[axis]
    return seen is not None and abs(seen - place) <= TOLERANCES.get(axis, ZOOM_TOLERANCE * abs(place))


def _is_still(result: Result) -> Phase:
    return Phase.MOVING if result["moving"] else Phase.ARRIVED

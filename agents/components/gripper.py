"""The agent of a gripper: two paddles on a lift. A motion ends at its goal, or when the paddles hold an object."""

from collections.abc import Callable, Mapping
from typing import Any, ClassVar

from agents.components.motions import MotionGoal, Phase
from agents.components.moving import MovingElementAgent, Result
from agents.platform import request
from bus import keys

PADDLES, LIFT = "paddles", "lift"
LONGEST = 20.0
"""Seconds for any motion; the robot's own patience with motors that do not get there ends sooner."""
STOPPING_TIME = 5.0


class GripperAgent(MovingElementAgent):
    """`gripper@happy`. Two requests may move paddles and lift at the same time; `stop` stops both."""

    source = keys.GRIPPER
    orders = keys.GRIP
    results: ClassVar[Mapping[str, str]] = {
        "paddles": "open, closed (maybe on something), moving or between",
        "lift": "up, down, moving or between",
        "outer_beam, inner_beam": "something stands between the paddles",
        "left_contact, right_contact": "something presses on the paddle",
        "holds": "both paddles press, and on something that stands between them",
    }

    def result(self, message: Any) -> Mapping[str, Any]:
        """Return the positions of paddles and lift, in a word each, and their switches."""
        paddles = _place(message.paddles_moving, open=message.paddles_open, closed=message.paddles_closed)
        presses = message.left_contact and message.right_contact  # empty paddles also press on each other
        is_between = message.outer_beam or message.inner_beam
        return {
            "paddles": paddles,
            "lift": _place(message.lift_moving, up=message.lift_up, down=message.lift_down),
            "outer_beam": bool(message.outer_beam),
            "inner_beam": bool(message.inner_beam),
            "left_contact": bool(message.left_contact),
            "right_contact": bool(message.right_contact),
            "holds": bool(presses and is_between) and paddles in ("closed", "between"),
        }

    @request("open", agrees_itself=True)
    async def open_paddles(self, wait: bool = True, token: str = "") -> dict[str, Any]:
        """Open the paddles."""
        return await self._send("open", {PADDLES: "open"}, wait, token)

    @request("close", agrees_itself=True)
    async def close_paddles(self, wait: bool = True, token: str = "") -> dict[str, Any]:
        """Close the paddles, until they meet or hold something."""
        return await self._send("close", {PADDLES: "closed"}, wait, token)

    @request("up", agrees_itself=True)
    async def lift_up(self, wait: bool = True, token: str = "") -> dict[str, Any]:
        """Raise the lift."""
        return await self._send("up", {LIFT: "up"}, wait, token)

    @request("down", agrees_itself=True)
    async def lift_down(self, wait: bool = True, token: str = "") -> dict[str, Any]:
        """Lower the lift."""
        return await self._send("down", {LIFT: "down"}, wait, token)

    @request("store", agrees_itself=True)
    async def store(self, wait: bool = True, token: str = "") -> dict[str, Any]:
        """Close the paddles and raise the lift."""
        return await self._send("store", {PADDLES: "closed", LIFT: "up"}, wait, token)

    @request("deploy", agrees_itself=True)
    async def deploy(self, wait: bool = True, token: str = "") -> dict[str, Any]:
        """Open the paddles and lower the lift."""
        return await self._send("deploy", {PADDLES: "open", LIFT: "down"}, wait, token)

    @request("stop", agrees_itself=True)
    async def stop(self, token: str = "") -> dict[str, Any]:
        """Stop paddles and lift; an object that is held stays held."""
        goal = MotionGoal(f"{self.element} stop", (PADDLES, LIFT), _is_still, STOPPING_TIME)
        return await self.carry_out(goal, token, do="stop")

    async def _send(self, order: str, places: Mapping[str, str], wait: bool, token: str) -> dict[str, Any]:
        goal = MotionGoal(f"{self.element} {order}", tuple(places), _judge_of(places), LONGEST)
        return await self.carry_out(goal, token, wait, do=order)


def _judge_of(places: Mapping[str, str]) -> Callable[[Result], Phase]:
    """Return a judge for these parts. Paddles that hold an object are closed, independent of their switches."""

    def judge(result: Result) -> Phase:
        if any(result[part] == "moving" for part in places):
            return Phase.MOVING
        is_there = all(
            result[part] == place or (place == "closed" and result["holds"]) for part, place in places.items()
        )
        return Phase.ARRIVED if is_there else Phase.RESTING

    return judge


def _is_still(result: Result) -> Phase:
    return Phase.MOVING if "moving" in (result[PADDLES], result[LIFT]) else Phase.ARRIVED


def _place(is_moving: bool, **ends: bool) -> str:
    """Return the position of a motor, in a word."""
    return "moving" if is_moving else next((end for end, is_there in ends.items() if is_there), "between")

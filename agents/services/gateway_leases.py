"""The gateways' own leases, which arbiters ask for: `<robot>/lease` on the bus. The gateway has the last word.

A lease on a name has no gateway: an arbiter's book alone says who holds it.
"""

from collections.abc import Awaitable, Callable, Mapping
from typing import Any

from agents.services.lease_book import new_id
from agents.services.leases import NAMED, ROBOT, LeaseTarget
from bus import NoAnswer, NotAllowed, Refused, keys

ANSWER_TIME = 1.0  # s; what is asked again soon, such as a renewal
TAKING_TIME = 3.0  # s; what is asked once, so that a busy machine refuses nobody

Query = Callable[[str, Mapping[str, Any], float], Awaitable[dict[str, Any]]]


class GatewayAway(Exception):
    """A robot's gateway does not answer; what it was asked for may have been done."""


class GatewayLeases:
    """Asks gateways; all that they refuse is a `Refused` with their reason."""

    def __init__(self, query: Query) -> None:
        """Ask by this function, which takes key, arguments and s to wait."""
        self._query = query

    async def take(self, place: LeaseTarget, holder: str, priority: int, seconds: float) -> str:
        """Take a lease in a holder's name; return its token.

        Raises:
            Refused, GatewayAway: Not so.
        """
        if place.is_named:
            return new_id()
        wanted = {"do": "take", "holder": holder, "priority": priority, "seconds": seconds}
        if not place.is_whole:
            wanted["element"] = place.element
        answer = await self._ask(place.robot, wanted, TAKING_TIME)
        token = answer.get("token")
        if not isinstance(token, str):
            raise Refused(f"the gateway of {place.robot} gives no token; is it of this version?")
        return token

    async def renew(self, place: LeaseTarget, token: str, seconds: float) -> tuple[str, int]:
        """Let a lease last so long from now; return its holder and priority, which nobody knows of a name's.

        Raises:
            Refused, GatewayAway: Not so.
        """
        if place.is_named:
            return "", 0
        state = await self._ask(place.robot, {"do": "renew", "token": token, "seconds": seconds})
        if state.get("element", ROBOT) != place.element:
            raise Refused(f"this token is of a lease on another element than {place}")
        return str(state["holder"]), int(state["priority"])

    async def release(self, robot: str, token: str) -> None:
        """End a lease.

        Raises:
            Refused, GatewayAway: Not so.
        """
        if not robot.startswith(NAMED):
            await self._ask(robot, {"do": "release", "token": token})

    async def time_left(self, place: LeaseTarget, holder: str) -> float:
        """s until the lease ends that somebody has on a place; 0 when he has none.

        Raises:
            GatewayAway: Nobody knows.
        """
        if place.is_named:
            return 0.0
        match place.lease_in(await self._ask(place.robot, {"do": "show"})):
            case {"holder": str(name), "expires_in": int() | float() as left} if name == holder:
                return float(left)
        return 0.0

    async def holders(self, place: LeaseTarget) -> list[tuple[str, int]]:
        """Who holds a place, or a part of it, and with what priority.

        Raises:
            GatewayAway: Nobody knows.
        """
        if place.is_named:
            return []
        return place.holders(await self._ask(place.robot, {"do": "show"}, TAKING_TIME))

    async def _ask(self, robot: str, arguments: Mapping[str, Any], within: float = ANSWER_TIME) -> dict[str, Any]:
        try:
            return await self._query(keys.LEASE.key(robot), arguments, within)
        except (NoAnswer, TimeoutError) as err:
            raise GatewayAway(f"the gateway of {robot} does not answer; is the robot there?") from err
        except NotAllowed as err:
            raise Refused(str(err)) from err

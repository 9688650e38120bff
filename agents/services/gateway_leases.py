"""The leases of gateways, which arbiters take: `<robot>/lease` on the bus. The gateway decides.

A lease on a name has no gateway: only an arbiter's book records its holder.
"""

import secrets
from collections.abc import Awaitable, Callable, Iterator, Mapping
from typing import Any

from agents.services.leases import ID_BYTES, NAMED, ROBOT, LeaseTarget
from bus import Bus, NoAnswer, NotAllowed, Refused, TimedOut, keys
from bus.aio import ReplyQueue

ANSWER_TIME = 1.0  # s; for a query that is repeated soon, such as a renewal
TAKING_TIME = 3.0  # s; for a query that is not repeated, so that a busy machine causes no refusal
LISTING_TIME = 2.0  # s; for the leases of all robots

Query = Callable[[str, Mapping[str, Any], float], Awaitable[dict[str, Any]]]


class GatewayAway(Exception):
    """A robot's gateway does not answer; it may have carried out the request."""


class GatewayLeases:
    """Queries gateways; a refusal raises `Refused` with their reason."""

    def __init__(self, query: Query) -> None:
        """Query by this function, which takes key, arguments and s to wait."""
        self._query = query

    async def take(self, place: LeaseTarget, holder: str, priority: int, seconds: float) -> str:
        """Take a lease in a holder's name; return its token.

        Raises:
            Refused, GatewayAway: It was not done.
        """
        if place.is_named:
            return secrets.token_hex(ID_BYTES)
        wanted = {"do": "take", "holder": holder, "priority": priority, "seconds": seconds}
        if not place.is_whole:
            wanted["element"] = place.element
        answer = await self._ask(place.robot, wanted, TAKING_TIME)
        token = answer.get("token")
        if not isinstance(token, str):
            raise Refused(f"the gateway of {place.robot} gives no token; is it of this version?")
        return token

    async def renew(self, place: LeaseTarget, token: str, seconds: float) -> tuple[str, int]:
        """Renew a lease for this time; return its holder and priority, which are unknown for a name.

        Raises:
            Refused, GatewayAway: It was not done.
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
            Refused, GatewayAway: It was not done.
        """
        if not robot.startswith(NAMED):
            await self._ask(robot, {"do": "release", "token": token})

    async def time_left(self, place: LeaseTarget, holder: str) -> float:
        """Return the remaining time of a holder's lease on a target, s; 0 without one.

        Raises:
            GatewayAway: It is not known.
        """
        if place.is_named:
            return 0.0
        match place.lease_in(await self._ask(place.robot, {"do": "show"})):
            case {"holder": str(name), "expires_in": int() | float() as left} if name == holder:
                return float(left)
        return 0.0

    async def holders(self, place: LeaseTarget) -> list[tuple[str, int]]:
        """Return the holders of a target, or of a part of it, and their priorities.

        Raises:
            GatewayAway: It is not known.
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


async def held_leases(bus: Bus) -> tuple[list[dict[str, Any]], str]:
    """Return all leases of all robots, as their gateways know them.

    Returns:
        A row for each lease, sorted by what it is on: element, holder, priority, and the s until it expires. And why
        some may be missing, empty if none is.
    """
    found: list[dict[str, Any]] = []
    left_out = ""
    try:
        replies = ReplyQueue(LISTING_TIME)
        with bus.ask(f"*/{keys.LEASE_STATE.suffix}", None, replies.put, replies.put, LISTING_TIME, urgent=True):
            async for answer in replies:
                found += _held(keys.split(answer.key)[0], answer.value)
    except (TimedOut, Refused) as err:
        left_out = f"somebody is left out: {err}"
    except NoAnswer:
        pass  # no robot is there
    return sorted(found, key=lambda row: str(row["element"])), left_out


def _held(robot: str, state: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    """Return a gateway's answer, a row for each lease; what is no lease is left out."""
    parts = state.get("elements")
    elements = {f"{name}@{robot}": lease for name, lease in parts.items()} if isinstance(parts, Mapping) else {}
    for element, lease in {robot: state, **elements}.items():
        match lease:
            case {"holder": str(holder), "priority": int(priority), "expires_in": int() | float() as left}:
                yield {"element": element, "holder": holder, "priority": priority, "expires_in": left}

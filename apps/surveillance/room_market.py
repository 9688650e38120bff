"""The market of a patrol's rooms: who has which, auctions of rooms that nobody has, and trades between two robots."""

import asyncio
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from agents.platform import Agent, AgentName, Bid
from agents.platform.conversations.fipa_request import Request
from apps.surveillance.algorithms.neglect import NeglectLedger
from apps.surveillance.patrol_agent import LOCAL
from apps.surveillance.settings import AuctionSettings

_REPLY = 5.0  # s for an agent to answer
_NO_BIDS = 2.0  # s after an auction without bids until the next


@dataclass(slots=True)
class PatrolMember:
    """A robot of the team.

    serving: the conversation in which it serves. state: its latest, with `heard`, s of the loop's time. trouble: why it
    does not serve. again: s of the loop's time when it is asked again. begins: it is being asked. has_joined: it has
    reported in this conversation. is_lost: its localization has lost it, so it may be what others see.
    map: file of the map on which it joined first.
    """

    serving: Request | None = None
    state: Mapping[str, Any] = field(default_factory=dict)
    heard: float = 0.0
    trouble: str = ""
    again: float = 0.0
    begins: bool = False
    has_joined: bool = False
    is_lost: bool = False
    map: str = ""

    @property
    def serves(self) -> bool:
        """Whether it patrols."""
        return self.serving is not None and bool(self.state.get("serves"))


class RoomMarket:
    """Calls for proposals for rooms, in the event loop of the manager. assigned: robot by room.

    is_trade_due: trades are to be tried, since the team or its rooms have changed.
    """

    def __init__(self, agent: Agent, members: Mapping[str, PatrolMember], settings: AuctionSettings) -> None:
        """Begin; nobody has a room.

        Args:
            agent: The manager.
            members: Robots by name, as they are at each time.
            settings: Of the auctions.
        """
        self.assigned: dict[str, str] = {}
        self.is_trade_due = False
        self._agent, self._members, self._settings = agent, members, settings
        self._traded_at = 0.0

    @property
    def serving(self) -> list[str]:
        """Robots that patrol, in alphabetical order."""
        return sorted(robot for robot, each in self._members.items() if each.serves)

    def release(self, robot: str) -> None:
        """Have the rooms of a robot auctioned again."""
        for room in [room for room, owner in self.assigned.items() if owner == robot]:
            del self.assigned[room]

    async def settle(self, rooms: Iterable[str], ledger: NeglectLedger) -> None:
        """Have rooms without a robot taken, one after the other, and then robots trade rooms."""
        if not self.serving:
            return
        while unassigned := [room for room in rooms if room not in self.assigned]:
            if not await self._sell(unassigned, ledger):
                await asyncio.sleep(_NO_BIDS)
                return
            self.is_trade_due = True
        if self.is_trade_due or self._clock() - self._traded_at > self._settings.trade_s:
            self.is_trade_due, self._traded_at = False, self._clock()
            for _ in range(self._settings.trades):
                if not await self._trade(ledger):
                    break

    def _clock(self) -> float:
        return asyncio.get_running_loop().time()

    async def _sell(self, rooms: Sequence[str], ledger: NeglectLedger) -> bool:
        """Auction one of some rooms; return whether a robot has taken it."""
        tender = await self._agent.call_for_proposals(
            [AgentName(LOCAL, robot) for robot in self.serving],
            "take_room",
            choose=lambda bids: min(bids, key=_rank),
            bids_within=self._settings.bids_s,
            reply_within=_REPLY,
            rooms=_neglects(rooms, ledger, self._clock()),
        )
        for peer, result in tender.done.items():
            if self._members[peer.platform].serves:
                self.assigned[str(result["room"])] = peer.platform
        return bool(tender.done)

    async def _trade(self, ledger: NeglectLedger) -> bool:
        """Have robots trade rooms, beginning with the one whose tour is longest; return whether two have."""
        periods = {robot: float(self._members[robot].state.get("period") or 0.0) for robot in self.serving}
        for giver in sorted(periods, key=lambda robot: -periods[robot]):
            theirs = [room for room, owner in self.assigned.items() if owner == giver]
            others = [robot for robot in periods if robot != giver]
            if not theirs or not others:
                continue
            tender = await self._agent.call_for_proposals(
                [AgentName(LOCAL, robot) for robot in others],
                "trade_rooms",
                choose=self._best_trade,
                bids_within=self._settings.bids_s,
                reply_within=_REPLY,
                theirs=theirs,
                neglect=_neglects(theirs, ledger, self._clock()),
            )
            for peer, result in tender.done.items():
                await self._hand_over(giver, peer.platform, str(result["room"]), str(result["back"]), ledger)
                return True
        return False

    def _best_trade(self, bids: Sequence[Bid]) -> Bid | None:
        best = min(bids, key=lambda bid: float(bid.proposal["gain"]))
        return best if float(best.proposal["gain"]) < self._settings.trade else None

    async def _hand_over(self, giver: str, taker: str, room: str, back: str, ledger: NeglectLedger) -> None:
        """Complete a trade at the robot that was called for it."""
        self.assigned[room] = taker
        if back:
            self.assigned.pop(back, None)
        neglected = _neglects([back], ledger, self._clock())[back] if back else None
        done = await self._agent.request(
            AgentName(LOCAL, giver), "exchange", reply_within=_REPLY, give=room, take=back, neglected=neglected
        )
        if done.is_done and back and self._members[giver].serves:
            self.assigned[back] = giver


def _neglects(rooms: Sequence[str], ledger: NeglectLedger, now: float) -> dict[str, float | None]:
    """How long rooms were not visited, s; None for those that were never."""
    neglect = ledger.neglect(now)
    return {room: neglect[room] if ledger.count(room) else None for room in rooms}


def _rank(bid: Bid) -> tuple[float, float, float, str]:
    """The order of bids for a room: the best first."""
    told = bid.proposal
    return float(told["period"]), float(told["added"]), float(told["way"]), str(bid.bidder)

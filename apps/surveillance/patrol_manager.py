"""The manager of a patrol: it auctions rooms to the robots by contract net, hears their alarms, and sends them to help.

It is the initiator of FIPA's contract net; the contractors are the agents `patrol@ROBOT`, which it starts beside the
agents of each robot. Each of them serves in a conversation that the manager keeps open.
"""

import asyncio
import json
from collections import deque
from collections.abc import Coroutine, Mapping, Sequence
from contextlib import suppress
from math import hypot
from typing import Any

from agents.platform import Agent, AgentError, AgentName, Bid, request
from agents.platform.containers import ContainerDirectory, order
from agents.platform.conversations.fipa_subscribe import FOREVER
from agents.platform.directory import Directory
from apps.surveillance.algorithms.intruders import TeamAlarm, TeamAlarms
from apps.surveillance.algorithms.neglect import NeglectLedger
from apps.surveillance.patrol_agent import KIND, LOCAL
from apps.surveillance.room_market import PatrolMember, RoomMarket
from apps.surveillance.settings import SurveillanceSettings
from bus import BusError, keys
from geometry import Point

BASE, INTERFACE, LOCALIZATION = "base", "user_interface", "localization"
NAME = "patrol_manager"
"""Its local name: `patrol_manager@apps`."""
PERIOD = 0.5  # s between two looks at the team
_PUBLISHED = 1.0  # s between two results
_REPLY = 5.0  # s for an agent to answer
_FOLLOWING = 600.0  # s for a follower to end; it ends by itself before
_EVENTS = 1000  # newest ones that are kept; some have a picture
_REPLIED = 20  # events of one reply
_REPLIED_SIZE = 200_000  # bytes of them, unless a single one is larger; a picture and a message are at most 256 KiB
_ALARMS = 200  # newest ones that are told
_SAME_VISIT = 1.5  # s between two reports of one visit
_ROOM_KINDS = ("Goal", "GoalWithHeading")


class PatrolManager(Agent):
    """Results once a second: `robots`, `rooms` with neglect, `alarms` (the newest 200), `longest` neglect.

    Properties: `settings` as a table; `rooms`: name to x and y in `map`, m, or none for the goals of the map; `robots`:
    names, all if empty; `starts`: robot to x, y (m) and heading (rad) in `map`, where its localization begins on `map`
    (a file) if it has not begun; `attention`: s without a request for the status, after which nobody patrols; 0 for no
    limit.
    """

    services = ("surveillance",)

    def __init__(self, name: AgentName | str, properties: Mapping[str, Any] | None = None) -> None:
        super().__init__(name, properties)
        given = self.properties
        self.tuned = SurveillanceSettings.of_table(given["settings"])
        self.places: dict[str, Point] = {room: (float(x), float(y)) for room, (x, y) in given["rooms"].items()}
        self.members: dict[str, PatrolMember] = {}
        self.market = RoomMarket(self, self.members, self.tuned.auction)
        self.ledger: NeglectLedger | None = None
        self.alarms = TeamAlarms(self.tuned.alarm)
        self.events: deque[dict[str, Any]] = deque(maxlen=_EVENTS)
        self._told: dict[tuple[str, int], TeamAlarm] = {}  # by robot and its number of the intruder
        self._tasks: set[asyncio.Task[None]] = set()

    async def setup(self) -> None:
        """Watch agents and containers, and begin."""
        self._clock = asyncio.get_running_loop().time
        self._attended_at = self._clock()
        self._directory = Directory(self.bus)
        self._containers = ContainerDirectory(self.bus)
        self.listen(f"*/agents/{LOCAL}/results", self._hear, keep=64, keyed=True)
        self.every(PERIOD, self._look_after)
        self.every(PERIOD, self._auction)
        self.every(_PUBLISHED, self._publish_state)

    async def take_down(self) -> None:
        """End all conversations, so that the robots stop."""
        servings = [each.serving for each in self.members.values() if each.serving is not None]
        for task in list(self._tasks):
            task.cancel()
        # One that fails is to keep no other from ending; its robot stops by the missing heartbeat.
        await asyncio.gather(*(each.cancel() for each in servings), *self._tasks, return_exceptions=True)
        self._directory.close()
        self._containers.close()

    @request("status")
    async def status(self) -> dict[str, Any]:
        """Return what the results have."""
        self._attended_at = self._clock()
        return self.state_of_patrol()

    @request("events")
    async def events_since(self, number: int = 0) -> list[dict[str, Any]]:
        """Return what has happened from the event with this number on: number, time (s since 1970), text and more.

        Only the first few events are returned, since some have pictures; ask again from the number after the last one.
        """
        found: list[dict[str, Any]] = []
        size = 0
        for event in self.events:
            if event["number"] >= number:
                size += len(json.dumps(event))
                if found and (len(found) == _REPLIED or size > _REPLIED_SIZE):
                    break
                found.append(event)
        return found

    def state_of_patrol(self) -> dict[str, Any]:
        """Return what the results have."""
        now = self._clock()
        ledger = self.ledger
        neglect, longest = (ledger.neglect(now), ledger.longest(now)) if ledger is not None else ({}, {})
        return {
            "stamp": self.home.wall_time(),
            "robots": {
                robot: {
                    "serves": each.serves,
                    "does": each.state.get("does") if each.serves else each.trouble or "begins",
                    "pose": each.state.get("pose"),
                    "rooms": each.state.get("rooms", []) if each.serves else [],
                    "next": each.state.get("next") if each.serves else None,
                    "period": each.state.get("period") if each.serves else None,
                    "follows": bool(each.state.get("follows")) and each.serves,
                }
                for robot, each in self.members.items()
            },
            "rooms": {
                room: {
                    "x": x,
                    "y": y,
                    "robot": self.market.assigned.get(room),
                    "neglect": round(neglect.get(room, 0.0), 1),
                    "longest": round(longest.get(room, 0.0), 1),
                    "visits": ledger.count(room) if ledger is not None else 0,
                }
                for room, (x, y) in self.places.items()
            },
            "longest": round(max(longest.values(), default=0.0), 1),
            "alarms": [self._described(each) for each in self.alarms.alarms[-_ALARMS:]],
        }

    def _described(self, alarm: TeamAlarm) -> dict[str, Any]:
        return {
            "number": alarm.number,
            "ago": round(self._clock() - alarm.time, 1),
            "seen_ago": round(self._clock() - alarm.seen_at, 1),
            "robot": alarm.robot,
            "sensor": alarm.sensor,
            "x": round(alarm.place[0], 2),
            "y": round(alarm.place[1], 2),
            "room": self._nearest_room(alarm.place),
            "follower": alarm.follower or None,
            "may_be": list(alarm.may_be),
        }

    def _nearest_room(self, place: Point) -> str | None:
        away = {room: hypot(x - place[0], y - place[1]) for room, (x, y) in self.places.items()}
        return min(away, key=lambda room: away[room], default=None)

    async def _publish_state(self) -> None:
        if self.is_heard:
            self.publish(self.state_of_patrol())

    def _tell(self, text: str, **more: Any) -> None:
        number = self.events[-1]["number"] + 1 if self.events else 0
        self.events.append({"number": number, "time": self.home.wall_time(), "text": text, **more})

    def _begin(self, work: Coroutine[Any, Any, None]) -> None:
        task = asyncio.ensure_future(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    # The team.

    async def _look_after(self) -> None:
        """Have robots begin, and end those that are silent."""
        now, attention = self._clock(), float(self.properties["attention"])
        is_attended = not attention or now - self._attended_at < attention
        wanted = self.properties["robots"]
        for name in self._directory.names:
            if name.local == BASE and (not wanted or name.platform in wanted):
                self.members.setdefault(name.platform, PatrolMember())
        for robot, member in self.members.items():
            if member.serving is None:
                is_there = self._directory.knows(AgentName(BASE, robot))
                if is_attended and is_there and not member.begins and now >= member.again:
                    member.begins = True
                    self._begin(self._serve(robot, member))
                elif not is_there:
                    member.trouble = "is not there"
            elif member.trouble:
                pass  # it is being ended
            elif not is_attended:
                self._begin(self._end(member, "the program does not ask any more"))
            elif now - member.heard > self.tuned.trust.silent_s:
                self._begin(self._stop(robot))  # at once: a frozen agent does not confirm that it has ended
                self._begin(self._end(member, f"has been silent for {now - member.heard:.1f} s"))

    async def _end(self, member: PatrolMember, why: str) -> None:
        member.trouble = why
        if member.serving is not None:
            await member.serving.cancel()

    async def _serve(self, robot: str, member: PatrolMember) -> None:
        """Have one robot serve, until it does not any more."""
        trouble = file = ""
        try:
            await self._bring_up(robot)
            if not self.places:
                await self._find_rooms(robot)
            member.trouble = ""
            file = await self._map_of(robot, member)
            member.state, member.heard = {}, self._clock() + _REPLY
            rooms = {room: list(place) for room, place in self.places.items()}
            member.serving = self.begin_request(
                AgentName(LOCAL, robot), "serve", reply_within=FOREVER, rooms=rooms, settings=self.tuned.to_table()
            )
            outcome = await member.serving
            trouble = outcome.why
        except (BusError, AgentError, TimeoutError) as err:
            trouble = str(err) or "its agents do not answer"
        except asyncio.CancelledError:
            if member.serving is not None:
                await member.serving.cancel()
            raise
        finally:
            did_serve = member.has_joined
            member.serving, member.begins, member.has_joined = None, False, False
            member.trouble = member.trouble or trouble
            member.again = self._clock() + self.tuned.auction.retry_s
            member.state = {**member.state, "serves": False}
            self.market.release(robot)
        if did_serve:
            member.map = member.map or file
            self._tell(f"{robot} leaves the patrol: {member.trouble}", robot=robot)
            await self._stop(robot)

    async def _bring_up(self, robot: str) -> None:
        """Start the agent of the patrol, and the localization if its start is given.

        Raises:
            AgentError, BusError, TimeoutError: It is not possible.
        """
        base = await self._directory.find(AgentName(BASE, robot))
        patrol = AgentName(LOCAL, robot)
        if not self._directory.knows(patrol):
            container = None if base is None else self._containers.find(base.container)
            if container is None:
                raise AgentError(f"the container of {robot} is not known yet")
            await order(self.bus, container, "start", name=str(patrol), kind=KIND, properties={})
        start = self.properties["starts"].get(robot)
        localization = AgentName(LOCALIZATION, robot)
        if start is None or not self._directory.knows(localization):
            return
        told = await self.request(localization, "state", reply_within=_REPLY)
        if told.is_done and told.result["state"] == "stopped":
            begun = await self.request(
                localization, "start", reply_within=60.0, map=self.properties["map"], pose=list(start)
            )
            begun.value()

    async def _map_of(self, robot: str, member: PatrolMember) -> str:
        """Return the file of the map on which a robot is localized; empty if it is not.

        Raises:
            AgentError: The robot joined first on another map, in which the places of the rooms may be elsewhere.
        """
        told = await self.request(AgentName(LOCALIZATION, robot), "state", reply_within=_REPLY)
        file = str(told.result.get("map") or "") if told.is_done else ""
        if file and member.map and file != member.map:
            raise AgentError(f"is localized on {file}, and the rooms are places in {member.map}; restart the patrol")
        return file

    async def _find_rooms(self, robot: str) -> None:
        """Take the goals of the map on which a robot is localized, or those of them that the settings name.

        Raises:
            RequestNotDone: The robot is not localized.
            AgentError: The map has no such goal.
        """
        told = await self.request(AgentName(LOCALIZATION, robot), "goals", reply_within=_REPLY)
        goals = {
            str(goal["name"]): (float(goal["pose"][0]), float(goal["pose"][1]))
            for goal in told.value()
            if goal["kind"] in _ROOM_KINDS
        }
        wanted = self.tuned.rooms or tuple(goals)
        if missing := [room for room in wanted if room not in goals]:
            raise AgentError(f"the map of {robot} has no goal {missing[0]!r}; it has {', '.join(goals) or 'none'}")
        if not goals:
            raise AgentError(f"the map of {robot} has no goals; name rooms with their places")
        self.places = self.places or {room: goals[room] for room in wanted}

    async def _stop(self, robot: str) -> None:
        """Stop a robot whose agent may have died or frozen: its mission, and what its gateway does."""
        interface = AgentName(INTERFACE, robot)
        with suppress(BusError, AgentError, TimeoutError):  # it may be what has died; the stop below needs no agent
            if self._directory.knows(interface):
                await self.request(interface, "cancel", reply_within=_REPLY)
        try:
            await self.query(keys.STOP.key(robot), timeout=_REPLY)
        except (BusError, AgentError, TimeoutError):
            self._tell(f"{robot} has not confirmed that it stands: its gateway does not answer", robot=robot)

    # Rooms.

    @property
    def serving(self) -> list[str]:
        """Robots that patrol, in alphabetical order."""
        return sorted(robot for robot, each in self.members.items() if each.serves)

    async def _auction(self) -> None:
        """Have rooms without a robot taken, and rooms traded."""
        if self.ledger is not None:
            await self.market.settle(self.places, self.ledger)

    # What the robots report.

    async def _hear(self, key: str, told: dict[str, Any]) -> None:
        robot = keys.split(key)[0]
        member = self.members.get(robot)
        if member is None or member.serving is None:
            return
        if told.get("event") == "alarm":
            self._take_picture(robot, told)
            return
        now = self._clock()
        member.state, member.heard = told, now
        if not member.serves:
            return
        member.is_lost = told.get("pose") is None
        if not member.has_joined:
            member.has_joined = True
            self.ledger = self.ledger or NeglectLedger(self.places, now)
            self.market.is_trade_due = True
            self._tell(f"{robot} joins the patrol", robot=robot)
        assert self.ledger is not None
        for room, ago in told.get("visits", {}).items():
            self._take_visit(room, robot, now - float(ago))
        for room, why in told.get("returned", {}).items():
            if self.market.assigned.get(room) == robot:
                del self.market.assigned[room]
                self._tell(f"{robot} cannot reach {room}: {why}", robot=robot, room=room)
        for each in told.get("intruders", []):
            self._take_intruder(robot, each)

    def _take_visit(self, room: str, robot: str, at: float) -> None:
        assert self.ledger is not None
        before = next((each.time for each in reversed(self.ledger.visits) if each.room == room), None)
        if room in self.places and (before is None or at - before > _SAME_VISIT):
            self.ledger.visit(room, robot, at)

    def _take_intruder(self, robot: str, told: Mapping[str, Any]) -> None:
        place = float(told["x"]), float(told["y"])
        alarm, is_new = self.alarms.take(self._clock(), robot, str(told["sensor"]), place)
        self._told[robot, int(told["intruder"])] = alarm
        if alarm.follower not in ("", robot):
            self._begin(self._pass_on(alarm))
        lost = tuple(sorted(name for name, each in self.members.items() if each.is_lost and name != robot))
        where = f"by {alarm.sensor} at ({place[0]:.1f}, {place[1]:.1f}), near {self._nearest_room(place)}"
        if is_new and lost:
            alarm.may_be = lost
            doubt = f"it may be {' or '.join(lost)}, which is not localized, so nobody follows it"
            self._tell(f"alarm {alarm.number}: {robot} sees something {where}; {doubt}", alarm=alarm.number)
        elif is_new or (alarm.may_be and not lost):
            alarm.may_be = ()
            self._tell(f"alarm {alarm.number}: {robot} sees an intruder {where}", alarm=alarm.number)
            self._begin(self._send_follower(alarm))

    def _take_picture(self, robot: str, told: Mapping[str, Any]) -> None:
        alarm = self._told.get((robot, int(told["intruder"])))
        if alarm is not None and told.get("picture"):
            self._tell(f"alarm {alarm.number}: picture of {robot}", alarm=alarm.number, picture=told["picture"])

    async def _pass_on(self, alarm: TeamAlarm) -> None:
        """Tell the follower of an intruder where another robot sees it."""
        x, y = alarm.place
        with suppress(BusError, AgentError):  # it has the place before this one, and sees it soon by itself
            await self.request(AgentName(LOCAL, alarm.follower), "sighting", reply_within=_REPLY, x=x, y=y)

    async def _send_follower(self, alarm: TeamAlarm) -> None:
        """Have the nearest robot that is able follow an intruder."""

        def choose(bids: Sequence[Bid]) -> Bid:
            best = min(bids, key=lambda bid: (float(bid.proposal["way"]), str(bid.bidder)))
            alarm.follower = best.bidder.platform
            self._tell(f"alarm {alarm.number}: {alarm.follower} goes and follows", alarm=alarm.number)
            return best

        x, y = alarm.place
        tender = await self.call_for_proposals(
            [AgentName(LOCAL, robot) for robot in self.serving],
            "follow",
            choose=choose,
            bids_within=self.tuned.auction.bids_s,
            reply_within=_FOLLOWING,
            x=x,
            y=y,
        )
        for peer, result in tender.done.items():
            where = f"({float(result['x']):.1f}, {float(result['y']):.1f})"
            self._tell(f"alarm {alarm.number}: {peer.platform} has lost the intruder at {where}", alarm=alarm.number)
        alarm.follower = ""

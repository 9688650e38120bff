"""The agent of one robot on patrol: it bids for rooms, visits them, watches, and follows intruders.

The patrol manager starts it in the container of the robot's agents, and asks it to serve. It moves the robot only while
that conversation lasts and the manager's heartbeat is there, so the robot stops when the program of the manager ends,
dies or freezes.
"""

import asyncio
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import asdict
from math import isfinite
from typing import TYPE_CHECKING, Any, ClassVar

from agents.platform import Agent, AgentName, agree, attended, proposes, request
from agents.platform.directory import Directory
from bus import BusError, Refused, keys
from configs.loader import ConfigError
from geometry import MapError, Point

if TYPE_CHECKING:  # these load numpy and maps
    from apps.surveillance.algorithms.intruders import WatchedThing
    from apps.surveillance.patrol_duty import PatrolDuty, PatrollingRobot

KIND = f"{__name__}:PatrolAgent"
LOCAL = "patrol"
"""Its local name: `patrol@happy`."""
PERIOD = 0.5  # s between two reports of its state
PICTURE_TIME = 3.0  # s for the camera to give a picture of an intruder


class PatrolAgent(Agent):
    """`patrol@happy`: results have the state twice a second, and each alarm with a picture."""

    services: ClassVar[tuple[str, ...]] = ("patrol",)

    def __init__(self, name: AgentName | str, properties: Mapping[str, Any] | None = None) -> None:
        super().__init__(name, properties)
        self._duty: PatrolDuty | None = None
        self._robot: PatrollingRobot | None = None  # of the duty before
        self._pictures: set[asyncio.Task[None]] = set()

    async def setup(self) -> None:
        """Begin to watch which agents there are."""
        self._directory = Directory(self.bus)

    async def take_down(self) -> None:
        """Stop watching."""
        for each in self._pictures:
            each.cancel()
        self._directory.close()

    @request("serve", agrees_itself=True)
    async def serve(self, rooms: dict[str, Any], settings: dict[str, Any]) -> dict[str, Any]:
        """Patrol until the request is cancelled, its initiator is gone or silent, or the robot is not able any more.

        rooms: name to x and y in `map`, m. settings: all of the application's.
        Refused where the robot is not able to patrol: it is not localized, is charged, or has no sensor.
        """
        if self._duty is not None:
            raise Refused(f"{self.name} patrols for another program already")
        duty = await self._begun(rooms, settings)
        try:
            agree()
            self._show_state()
            with attended():
                reporting = self.every(PERIOD, self._tell)
                try:
                    why = await duty.run()
                finally:
                    reporting.stop()
        finally:
            self._duty = None
            await duty.close()
            self._show_state()
        raise Refused(why)

    @proposes("take_room")
    async def bid(self, rooms: dict[str, Any]) -> dict[str, Any]:
        """Propose to take one of the rooms: name to s since its last visit, null if it was never visited.

        room, period: of the tour afterwards, s. added: s. way: m to the room.
        """
        duty, place, now = self._serving()
        found = duty.plan.bid(rooms, place, now)
        if found is None:
            raise Refused(f"{self.name.platform} can reach none of these rooms")
        return asdict(found)

    @request("take_room")
    async def take_room(self, rooms: dict[str, Any]) -> dict[str, Any]:
        """Take the room that was proposed."""
        duty, place, now = self._serving()
        found = duty.plan.bid(rooms, place, now)
        if found is None:
            raise Refused(f"{self.name.platform} can reach none of these rooms any more")
        duty.take(found.room, place, rooms[found.room])
        self._show_state()
        return asdict(found)

    @proposes("trade_rooms")
    async def weigh_trade(self, theirs: list[str], neglect: dict[str, Any]) -> dict[str, Any]:
        """Propose a trade with a robot that has these rooms, in the order of its tour.

        room: that this robot takes. back: that it gives, empty for none. gain: below 1 for the better.
        """
        duty, place, now = self._serving()
        found = duty.plan.trade(theirs, place, now)
        if found is None:
            raise Refused("no trade is a gain")
        return asdict(found)

    @request("trade_rooms")
    async def trade_rooms(self, theirs: list[str], neglect: dict[str, Any]) -> dict[str, Any]:
        """Do what was proposed; neglect: as the rooms of `take_room`."""
        duty, place, now = self._serving()
        found = duty.plan.trade(theirs, place, now)
        if found is None:
            raise Refused("the trade is no gain any more")
        if found.back:
            duty.plan.give_up(found.back)
        duty.take(found.room, place, neglect.get(found.room))
        self._show_state()
        return asdict(found)

    @request("exchange")
    async def exchange(self, give: str, take: str, neglected: Any = None) -> dict[str, Any]:
        """Give up a room, and take another one if a name is given; neglected: s since its last visit."""
        duty, place, _ = self._serving()
        duty.plan.give_up(give)
        if take:
            duty.take(take, place, neglected)
        self._show_state()
        return {"rooms": list(duty.plan.order)}

    @proposes("follow")
    async def weigh_following(self, x: float, y: float) -> dict[str, Any]:
        """Propose to follow an intruder at x, y in `map`, m; way: m to it."""
        return {"way": self._way_to((x, y))}

    @request("follow")
    async def follow(self, x: float, y: float) -> dict[str, Any]:
        """Drive to an intruder and follow it until it is lost; return for how long it was followed, and where it was.

        seconds: s. x, y: m in `map`, the last place.
        """
        self._way_to((x, y))
        duty, _, _ = self._serving()
        return await duty.follow((x, y))

    @request("sighting")
    async def note_sighting(self, x: float, y: float) -> dict[str, Any]:
        """Note where another robot sees the intruder that this one follows, m in `map`."""
        duty, _, _ = self._serving()
        duty.note_sighting((x, y))
        return {"follows": duty.is_on_errand}

    @request("state")
    async def state_of_patrol(self) -> dict[str, Any]:
        """Return the state, as the results have it."""
        return self._state()

    def _way_to(self, place: Point) -> float:
        duty, here, _ = self._serving()
        if duty.is_on_errand:
            raise Refused(f"{self.name.platform} follows an intruder already")
        way = duty.plan.way(place, here)
        if not isfinite(way):
            raise Refused(f"{self.name.platform} cannot get there")
        return round(way, 2)

    def _serving(self) -> "tuple[PatrolDuty, Point, float]":
        """Return the duty, where the robot is, and the time.

        Raises:
            Refused: It does not serve, or the robot is lost.
        """
        duty = self._duty
        if duty is None:
            raise Refused(f"{self.name} does not patrol")
        pose = duty.senses.pose
        if pose is None:
            raise Refused(duty.senses.trouble)
        return duty, (pose.x, pose.y), asyncio.get_running_loop().time()

    async def _begun(self, rooms: Mapping[str, Any], settings: Mapping[str, Any]) -> "PatrolDuty":
        """Return the duty, subscribed to the robot's readings.

        Raises:
            Refused: The robot is not able to patrol.
        """
        from apps.surveillance.patrol_duty import PatrolDuty, prepared
        from apps.surveillance.settings import SurveillanceSettings

        try:
            tuned = SurveillanceSettings.of_table(settings)
            places = {name: (float(x), float(y)) for name, (x, y) in rooms.items()}
        except (ConfigError, TypeError, ValueError) as err:
            raise Refused(str(err)) from err
        try:
            robot = self._robot = await prepared(self, self._robot)
        except (MapError, ValueError, BusError, TimeoutError) as err:
            raise err if isinstance(err, Refused) else Refused(str(err)) from err
        duty = PatrolDuty(self, self._directory, robot, places, tuned, self._raise_alarm)
        self._duty = duty
        try:
            await duty.check()
        except BaseException:
            self._duty = None
            await duty.close()
            raise
        return duty

    async def _tell(self) -> None:
        self._show_state()

    def _show_state(self) -> None:
        with suppress(BusError):  # the agent is being stopped, and its results are closed already
            self.publish({"event": "state", **self._state()})
            if self._duty is not None and (shown := self._duty.overlay()) is not None:
                self.bus.put(keys.OVERLAY.key(self.name.platform, "surveillance"), shown)

    def _state(self) -> dict[str, Any]:
        stamp = self.home.wall_time()
        if self._duty is None:
            return {"stamp": stamp, "serves": False, "does": "does not patrol"}
        return {"stamp": stamp, "serves": True, **self._duty.state()}

    def _raise_alarm(self, number: int, thing: "WatchedThing") -> None:
        """Report an intruder at once, and again with a picture as soon as there is one."""
        self._show_state()
        task = asyncio.ensure_future(self._publish_alarm(number, thing))
        self._pictures.add(task)
        task.add_done_callback(self._pictures.discard)

    async def _publish_alarm(self, number: int, thing: "WatchedThing") -> None:
        x, y = thing.place
        told = {"event": "alarm", "stamp": self.home.wall_time(), "intruder": number, "sensor": str(thing.sensor)}
        picture = None
        camera = AgentName("camera", self.name.platform)
        if self._directory.knows(camera):
            with suppress(BusError, TimeoutError):  # the alarm counts without a picture as well
                outcome = await self.request(camera, "picture", reply_within=PICTURE_TIME)
                picture = outcome.result if outcome.is_done else None
        self.publish({**told, "x": round(x, 2), "y": round(y, 2), "picture": picture})

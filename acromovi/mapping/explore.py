"""Robots that explore: each is sent to frontiers of its map by requests to its indoor navigation."""

import asyncio
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from acromovi.mapping.grids import LiveGrids
from acromovi.navigation.components import USER_INTERFACE, RunningNavigation
from agents.platform.errors import AgentError, RequestNotDone
from bus import keys
from bus.bus import Bus
from bus.errors import BusError
from geometry import Point
from maps.building.exploring import Explorer, ExploringOrder, MissionStanding, RobotSight
from maps.building.merging import CommonFrame

if TYPE_CHECKING:
    from agents.platform import Agent, AgentName

REPLY = 5.0  # s for the navigation to answer
TOLERANCE = 0.3  # m from a frontier that count as reached
BESIDE = 0.05  # m left beside the robot
WIDTH = 0.5  # m of a robot that does not describe itself
STATES = {"done": MissionStanding.DONE, "failed": MissionStanding.FAILED}
STOPPED = ("cancelled", "replaced")
ARRIVING = 3.0  # s in which an order reaches path planning


class ExploringTeam:
    """The robots, their missions, and how their maps lie."""

    def __init__(
        self, bus: Bus, agent: "Agent", grids: LiveGrids, interfaces: dict[str, "AgentName"], radius: float
    ) -> None:
        self._bus = bus
        self._agent = agent
        self._grids = grids
        self._interfaces = interfaces
        self._explorer = Explorer(radius)
        self._missions: dict[str, tuple[str, float]] = {}  # name, and when it was sent, s of the loop's time
        self._frame = CommonFrame(grids.robots[0])

    @classmethod
    async def found(cls, bus: Bus, agent: "Agent", grids: LiveGrids) -> "ExploringTeam":
        """Find the navigation of each robot.

        Raises:
            NotOnBus: One does not navigate.
        """
        loop = asyncio.get_running_loop()
        interfaces, radius = {}, 0.0
        for robot in grids.robots:
            interfaces[robot] = await loop.run_in_executor(None, RunningNavigation(bus, robot).expect, USER_INTERFACE)
            radius = max(radius, await loop.run_in_executor(None, _half_width, bus, robot))
        return cls(bus, agent, grids, interfaces, radius + BESIDE)

    @property
    def targets(self) -> dict[str, Point]:
        """Frontiers that robots drive to, m in their maps."""
        return self._explorer.targets()

    async def step(self, now: float) -> bool:
        """Look at all missions and maps, and send robots on; return whether everything has been seen."""
        sights = {}
        for robot in self._grids.robots:
            grid, pose = self._grids.grid(robot), self._grids.poses.get(robot)
            if grid is not None and pose is not None:
                sights[robot] = RobotSight(grid, pose, await self._mission(robot))
        if len(sights) < len(self._grids.robots):
            return False
        loop = asyncio.get_running_loop()
        await loop.run_in_executor(None, self._frame.look, now, {robot: each.grid for robot, each in sights.items()})
        orders = await loop.run_in_executor(None, self._explorer.decide, now, sights, self._frame.poses)
        for robot, order in orders.items():
            await self._send(robot, order)
        return self._explorer.is_finished

    async def cancel(self) -> None:
        """Cancel what robots do; a robot whose navigation does not answer stops at the end of its mission."""
        for robot in list(self._missions):
            with suppress(AgentError, BusError):  # it cannot be reached; the others are cancelled all the same
                await self._send(robot, ExploringOrder(None))

    async def _mission(self, robot: str) -> MissionStanding:
        """How the mission of a robot stands.

        Raises:
            RequestNotDone: Another program has cancelled or replaced it: whoever did wants the robot elsewhere.
        """
        if robot not in self._missions:
            return MissionStanding.NONE
        name, sent_at = self._missions[robot]
        if not name:
            return MissionStanding.FAILED  # the goal was refused
        outcome = await self._agent.request(self._interfaces[robot], "state", reply_within=REPLY)
        told: dict[str, Any] = outcome.result if outcome.is_done else {"mission": name}
        state = str(told.get("state"))
        is_other = told.get("mission") != name
        if is_other and asyncio.get_running_loop().time() - sent_at < ARRIVING:
            return MissionStanding.ACTIVE
        if is_other or state in STOPPED:
            del self._missions[robot]
            raise RequestNotDone(f"another program has {state if not is_other else 'replaced'} the mission of {robot}")
        return STATES.get(state, MissionStanding.ACTIVE)

    async def _send(self, robot: str, order: ExploringOrder) -> None:
        """Send a robot to a place of its map, by its odometry; or let it stop."""
        interface = self._interfaces[robot]
        if order.goal is None:
            self._missions.pop(robot, None)
            await self._agent.request(interface, "cancel", reply_within=REPLY)
            return
        goal = order.goal.relative_to(self._grids.odometry[robot])
        # Before the reply: if the program is to end now, this mission is cancelled as well.
        self._missions[robot] = "", asyncio.get_running_loop().time()
        outcome = await self._agent.request(
            interface, "go", reply_within=REPLY, x=goal.x, y=goal.y, heading=goal.heading, tolerance=TOLERANCE
        )
        name = outcome.result["mission"] if outcome.is_done else ""
        self._missions[robot] = name, asyncio.get_running_loop().time()


def _half_width(bus: Bus, robot: str) -> float:
    """Half the width of a robot, m, by its description."""
    try:
        geometry = bus.query(keys.DESCRIPTION.key(robot))[0].value["geometry"]
        return float(geometry["width"]) / 2.0
    except (BusError, LookupError, TypeError, ValueError):
        return WIDTH / 2.0

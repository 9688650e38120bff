"""Missions: what to do next from readings and doors, one mission after the other."""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, replace
from math import inf
from typing import Any

from apps.indoor_navigation.algorithms.outline import Outline
from apps.indoor_navigation.algorithms.planning.driving import Driving
from apps.indoor_navigation.algorithms.planning.floor import FloorMap
from apps.indoor_navigation.algorithms.planning.frames import MAP, ODOM, PlanFrame
from apps.indoor_navigation.algorithms.planning.memory import Memory
from apps.indoor_navigation.algorithms.planning.orders import REST, MissionNote, MissionParameters, Order
from apps.indoor_navigation.algorithms.planning.pausing import Pausing
from apps.indoor_navigation.algorithms.planning.plan import Motion
from apps.indoor_navigation.algorithms.planning.recovering import Recovering
from apps.indoor_navigation.algorithms.planning.right_of_way import RightOfWay
from apps.indoor_navigation.algorithms.planning.situation import Situation
from apps.indoor_navigation.algorithms.planning.states import ACTIVE, MOVING, MissionEvent, MissionState
from apps.indoor_navigation.algorithms.planning.waiting import FOR_SIGHT
from apps.indoor_navigation.data import DIGITS, LEAST_TOLERANCE, DLEData, Door, GoalPoint, ObstRead, Place
from geometry import Pose2D

FIX_TIMEOUT = 4.0  # s for the localization to say where the robot is, and for its map to come
MAX_CHANGES = 8  # of state in one step; no sequence without an order is as long


@dataclass(frozen=True, slots=True)
class MapFix:
    """What the localization knows.

    odom: pose of odom on the map; None while the robot is not localized. why: that is. floor: the map; None until it
    has come.
    """

    odom: Pose2D | None
    floor: FloorMap | None
    why: str = ""


class Navigator:
    """Takes readings, and returns an order at each step. All times are s of one steady clock."""

    def __init__(self, parameters: MissionParameters, half_width: float) -> None:
        """half_width: of the robot, m."""
        self.parameters = parameters
        self.memory = Memory(parameters.guide.memory, Outline(half_width, half_width, 2.0 * half_width))
        self._situation = Situation(parameters, self.memory)
        self._frame = self._on_map = PlanFrame()  # the present one, and the last one on a map
        self._floor: FloorMap | None = None
        self._reading: ObstRead | None = None  # the last one, in odom
        driving, pausing = Driving(self._situation), Pausing(self._situation)
        self._handlers: dict[MissionState, Callable[[float], Order | None]] = {
            MissionState.REPLANNING: pausing.replan,
            MissionState.WAITING: pausing.wait,
            MissionState.LOST: Recovering(self._situation).seek,
            **dict.fromkeys(MOVING, driving.follow),
        }

    @property
    def state(self) -> MissionState:
        """The state of the mission."""
        return self._situation.state

    @property
    def is_active(self) -> bool:
        """Whether a mission is active."""
        return self.state in ACTIVE

    @property
    def why(self) -> str:
        """The reason for this state in words."""
        return self._situation.machine.why

    @property
    def rights(self) -> RightOfWay:
        """To passages of the map, where two robots cannot pass each other."""
        return self._situation.rights

    @property
    def notes(self) -> deque[MissionNote]:
        """Messages for people; the caller removes those that it sends."""
        return self._situation.notes

    def take_way_request(self) -> bool:
        """Return whether people in the way are to be asked now to let the robot pass; True once for each request."""
        situation = self._situation
        asks, situation.asks_for_way = situation.asks_for_way, False
        return asks

    def note(self, level: str, what: str) -> None:
        """Add a message about the present mission."""
        self._situation.note(level, what)

    # Inputs.

    def begin(self, goal: GoalPoint, now: float) -> None:
        """Begin a mission, or cancel the present one if the goal has no place."""
        situation = self._situation
        if goal.x is None or goal.y is None:
            if self.is_active:
                situation.machine.happens(MissionEvent.CALLED_OFF, now, "cancelled")
            return
        if self.is_active and situation.goal.mission != goal.mission:
            situation.note("warning", f"given up, because {goal.mission} replaces it")
        situation.begin(goal, self._frame.goal(goal) if goal.is_sound else goal, now)
        if not goal.is_sound:
            told = f"x {goal.x!r}, y {goal.y!r}, heading {goal.heading!r}, tolerance {goal.tolerance!r}"
            wanted = f"finite numbers, and a tolerance of at least {LEAST_TOLERANCE:g} m"
            situation.give_up(now, f"{told} is not a valid goal; give {wanted}")

    def see(self, reading: ObstRead, now: float) -> None:
        """Take a reading of obstacles, in odom."""
        situation = self._situation
        situation.seen_at, self._reading = now, reading
        if self.memory.see(self._frame.reading(reading)):
            situation.progress.begin()
            if self.is_active:
                situation.no_way_since = inf
                situation.machine.happens(
                    MissionEvent.POSE_JUMPED, now, "the robot's pose was set anew, and all that was seen is forgotten"
                )

    def see_doors(self, data: DLEData) -> None:
        """Take the doors of a scan, in odom."""
        self.memory.doors.see(self._frame.doors(data))

    def localize(self, fix: MapFix | None, now: float) -> None:
        """Take what the localization knows: the place of odom on a map; None without a localization."""
        if fix is not None and fix.odom is not None and fix.floor is not None:
            if not self._frame.is_map or fix.floor is not self._floor:
                self._enter(fix.floor, fix.odom, now)
            elif self._reading is None or self._frame.is_corrected_by(fix.odom, self._reading.pose):
                self._frame = self._on_map = PlanFrame(MAP, fix.odom)
        elif self._frame.is_map:
            self._leave(fix.why if fix is not None else "the localization has ended", now)

    def _enter(self, floor: FloorMap, odom: Pose2D, now: float) -> None:
        """Plan on a map from now on."""
        situation = self._situation
        self._on_map = PlanFrame(MAP, odom)
        self._use(self._on_map, floor)
        if not self.is_active:
            return
        words = "the robot knows its place on the map"
        situation.note("info", f"{words} again" if situation.seeking is not None else words)
        situation.seeking = None
        situation.set_goal(self._frame.goal(situation.told))
        situation.machine.happens(MissionEvent.POSE_JUMPED, now, words)

    def _leave(self, why: str, now: float) -> None:
        """Plan by the sensors alone from now on."""
        situation = self._situation
        self._use(PlanFrame(), None)
        if not self.is_active:
            return
        if situation.told.frame == MAP:
            situation.lose(now, why)
        else:
            situation.set_goal(situation.told)
            situation.machine.happens(MissionEvent.POSE_JUMPED, now, f"continues without a map: {why}")

    def _use(self, frame: PlanFrame, floor: FloorMap | None) -> None:
        self._frame, self._floor = frame, floor
        self.memory.use_map(floor)
        self.rights.use_map(floor)
        if self._reading is not None:
            self.memory.see(frame.reading(self._reading))

    # Outputs.

    def step(self, now: float) -> Order:
        """Return the order for now, in odom."""
        order = self._step(now)
        if order.aim in (Motion.GO, Motion.BACK, Motion.TURN):
            speed = order.speed / 2.0 if self._situation.seeking is not None else order.speed
            barred = tuple(self.memory.forbidden_near().round(DIGITS).ravel().tolist())
            order = replace(order, speed=speed, barred=barred)
        return self._frame.order(order)

    def _step(self, now: float) -> Order:
        situation = self._situation
        if self.memory.pose is not None:
            situation.look_for_passages()
        if self.is_active and situation.told.frame == MAP and not self._frame.is_map and situation.seeking is None:
            if now - situation.begun < FIX_TIMEOUT:
                return REST
            situation.give_up(now, "the robot is not localized on a map; start that with: acromovi localize")
        for _ in range(MAX_CHANGES):
            if not self.is_active:
                break
            waits_for_sight = self.state is MissionState.WAITING and situation.waiting is FOR_SIGHT
            if situation.is_blind(now) and not waits_for_sight:
                situation.wait_for(now, MissionEvent.BLIND, FOR_SIGHT)
            order = self._handlers[self.state](now)
            if order is not None:
                return order
        return REST

    def status(self) -> dict[str, Any]:
        """Return the state of the mission as JSON. messages: number of notes. since: s of the clock of the steps.

        Places are in odom. frame: that of the planning, `map` while the robot is localized. on_map: the goal as it was
        given, if that is a place of the map.
        """
        situation, pose, frame = self._situation, self.memory.pose, self._frame
        target = situation.guide.sub_target if self.is_active else None
        told = situation.told
        return {
            "mission": situation.goal.mission,
            "state": str(self.state),
            "why": self.why,
            "messages": situation.noted,
            "since": situation.machine.since,
            "goal": self._goal_in_odom(told).to_json(),
            "on_map": [told.x, told.y, told.heading] if told.frame == MAP else None,
            "frame": frame.name,
            "sub_target": list(frame.place_in_odom(target)) if target is not None else None,
            "travelled": self.memory.travelled,
            "pose": list(frame.in_odom(pose)) if pose is not None else None,
        }

    def picture(self) -> dict[str, Any]:
        """Return the data of a picture as JSON, in odom. route: points from the robot on. ends: of the pieces."""
        frame = self._frame
        ends = self._situation.guide.ends if self.is_active else ()
        known = self.memory.picture(frame.in_odom)
        if frame.is_map:
            known["grid"] = self.memory.grid.area.turned(Pose2D().relative_to(frame.odom)).drawn()
        route = {
            "route": list(map(list, self.route())),
            "ends": [list(frame.place_in_odom(end)) for end in ends],
        }
        return {**self.status(), **known, **route}

    def route(self) -> list[Place]:
        """Return the points from the robot to the end of the way, in odom; none where no mission is active."""
        points = self._situation.guide.points if self.is_active else ()
        return [self._frame.place_in_odom(point) for point in points]

    def doors(self) -> list[Door]:
        """Return all doors that are known, in odom."""
        placed = ((door, self._frame.in_odom((door.x, door.y, door.normal))) for door in self.memory.doors.doors)
        return [Door(x, y, door.width, normal, door.confidence) for door, (x, y, normal) in placed]

    def _goal_in_odom(self, goal: GoalPoint) -> GoalPoint:
        """Return a goal in odom by the last place of odom on a map; one of a map that never came stays as it is."""
        if goal.frame != MAP or not self._on_map.is_map or goal.x is None or goal.y is None or not goal.is_sound:
            return goal
        x, y, heading = self._on_map.in_odom((goal.x, goal.y, goal.heading or 0.0))
        return replace(goal, x=x, y=y, heading=None if goal.heading is None else heading, frame=ODOM)

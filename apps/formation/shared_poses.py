"""Poses shared on the bus: the odometry of each robot, placed where the robot started."""

import math
from collections.abc import Mapping, Sequence
from concurrent.futures import wait
from dataclasses import dataclass

import configs
from agents import Robot, RobotError
from apps.background import BackgroundRequests
from apps.formation.members import MemberState, RangeEcho
from configs.team_file import read_team
from geometry import Pose2D, Twist2D

FASTEST = 3.0  # m/s; no robot here is faster
LEAP = 0.3  # m beyond that by which odometry moves only when a gateway has started again, with a new origin
ECHOES_FOR = 1.0  # s for which the echoes of a sonar hold; without newer ones the robot is not driven
ANSWER_TIME = 1.0  # s for a reading or a command; the other robots do not wait for it


def read_starts(given: object, robots: Sequence[str]) -> dict[str, Pose2D]:
    """Return where each robot stood when its gateway first connected, in one frame.

    Args:
        given: A team file by its name, or `{"happy": [x, y, heading]}` in m, m and degrees.
        robots: Names.
    Raises:
        RobotError: The start of a robot is missing or not valid.
    """
    if isinstance(given, str):
        try:
            rows = read_team(given).robots
        except configs.ConfigError as err:
            raise RobotError(str(err)) from err
        starts = {row.name: Pose2D(*row.at_m, math.radians(row.heading_deg)) for row in rows if row.at_m is not None}
    elif isinstance(given, Mapping):
        starts = {str(name): _pose(name, row) for name, row in given.items()}
    else:
        raise RobotError(f"starts is a team file or {{robot: [x, y, heading]}}, not {given!r}")
    if unknown := [name for name in robots if name not in starts]:
        named = given if isinstance(given, str) else "starts"
        raise RobotError(
            f'{named} gives no start of {", ".join(unknown)}; add at_m, or starts={{"{unknown[0]}":[0,0,0]}}'
        )
    return {name: starts[name] for name in robots}


def _pose(name: object, row: object) -> Pose2D:
    match row:
        case [int() | float() as x, int() | float() as y, *rest] if len(rest) <= 1:
            heading = rest[0] if rest else 0.0
            if isinstance(heading, int | float) and all(map(math.isfinite, (x, y, heading))):
                return Pose2D(x, y, math.radians(heading))
    raise RobotError(f"the start of {name} is {row!r}; expected [x, y, heading] in m, m and degrees")


@dataclass(slots=True)
class _Shared:
    """What a robot has answered.

    stamp, sonar_stamp: of the latest readings, s on the gateway's clock. echoes_at: when the latter was new.
    refusal: why it cannot be driven, in words.
    """

    robot: Robot
    start: Pose2D
    has_sonar: bool
    stamp: float = math.nan
    state: MemberState | None = None
    echoes: tuple[RangeEcho, ...] = ()
    sonar_stamp: float = math.nan
    echoes_at: float = -math.inf
    refusal: str = ""
    has_leapt: bool = False


def _leaps(before: MemberState | None, after: MemberState) -> bool:
    if before is None:
        return False
    way = math.dist((before.pose.x, before.pose.y), (after.pose.x, after.pose.y))
    return way > LEAP + FASTEST * (after.heard - before.heard)


class SharedPoses:
    """Reads odometry and sonar of all robots, and drives them; implements `PoseSource`.

    A robot that does not answer holds up no other. Each robot has at most one request of a kind under way; none lasts
    longer than `ANSWER_TIME`, so that a program that hangs soon counts as unattended and its robots stop.
    """

    def __init__(self, robots: Sequence[Robot], starts: Mapping[str, Pose2D], period: float) -> None:
        """Begin with robots that are there.

        Args:
            robots: Leader and followers.
            starts: Pose of each when its gateway first connected.
            period: s that a call of `read` lasts at most.
        Raises:
            RobotError: A robot has no base.
        """
        self._period = period
        self._requests = BackgroundRequests(3 * len(robots), "formation")
        self._shared = {each.name: _Shared(each, starts[each.name], each.has("sonar")) for each in robots}
        for each in self._shared.values():
            each.robot.element("base")

    def read(self, now: float) -> dict[str, MemberState]:
        """Return the state of each robot that has been heard of; `now` is s on any steady clock."""
        asked = []
        for shared in self._shared.values():
            asked.append(self._requests.begin((shared.robot.name, "odometry"), self._ask_odometry, shared))
            if shared.has_sonar:
                asked.append(self._requests.begin((shared.robot.name, "sonar"), self._ask_sonar, shared))
        wait(asked, self._period / 2)
        states = {}
        for name, shared in self._shared.items():
            self._take(shared, now)
            if shared.state is not None:
                states[name] = shared.state
        return states

    def drive(self, name: str, twist: Twist2D) -> str:
        """Drive a robot, unless it is lost; returns why it cannot be driven, in words, or nothing."""
        shared = self._shared[name]
        before = self._requests.take((name, "drive"))
        if before is not None:
            error = before.exception()
            shared.refusal = str(error) if isinstance(error, RobotError) else ""
        if shared.has_leapt:
            twist = Twist2D()
            shared.refusal = "its odometry has jumped, as when a gateway starts again; start anew with new starts"
        self._requests.begin((name, "drive"), shared.robot.base.drive, twist.linear, twist.angular)
        return shared.refusal

    def has_leapt(self, name: str) -> bool:
        """Return whether the odometry of a robot has jumped, so that nobody knows any more where it is."""
        return self._shared[name].has_leapt

    def close(self) -> None:
        """Begin no more requests."""
        self._requests.close()

    def _take(self, shared: _Shared, now: float) -> None:
        """Take what has been answered."""
        sonar = self._requests.take((shared.robot.name, "sonar"))
        odometry = self._requests.take((shared.robot.name, "odometry"))
        if sonar is not None and sonar.exception() is None:
            sonar_stamp, echoes = sonar.result()
            if sonar_stamp != shared.sonar_stamp:  # the same reading again tells nothing of what is there now
                shared.sonar_stamp, shared.echoes, shared.echoes_at = sonar_stamp, echoes, now
        is_blind = shared.has_sonar and now - shared.echoes_at > ECHOES_FOR
        if odometry is not None and odometry.exception() is None:
            stamp, pose, twist = odometry.result()
            if stamp != shared.stamp:  # the same reading again is no sign of life
                shared.stamp = stamp
                echoes, trouble = ((), "has a silent sonar") if is_blind else (shared.echoes, "")
                state = MemberState(shared.start.compose(pose), twist, now, echoes, trouble)
                shared.has_leapt = shared.has_leapt or _leaps(shared.state, state)
                shared.state = state if not shared.has_leapt else shared.state

    @staticmethod
    def _ask_odometry(shared: _Shared) -> tuple[float, Pose2D, Twist2D]:
        told = shared.robot.base.ask("read", within=ANSWER_TIME)
        pose = Pose2D(float(told["x"]), float(told["y"]), float(told["heading"]))
        return float(told["stamp"]), pose, Twist2D(float(told["linear"]), float(told["angular"]))

    @staticmethod
    def _ask_sonar(shared: _Shared) -> tuple[float, tuple[RangeEcho, ...]]:
        told = shared.robot.sonar.ask("read", within=ANSWER_TIME)
        discs = shared.robot.sonar.discs
        return float(told["stamp"]), tuple(
            RangeEcho(number, Pose2D(discs[number].x, discs[number].y, discs[number].heading), float(distance))
            for number, distance in told["ranges"].items()
            if distance is not None and number in discs
        )

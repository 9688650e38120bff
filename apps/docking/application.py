"""The application: a robot drives onto its dock, at once or when its battery is low, and answers requests."""

import math
import time
from collections.abc import Callable
from contextlib import nullcontext, suppress
from typing import Any

import numpy as np

import configs
from agents import Failed, NotThere, Refused, Robot, RobotError, Stopped, Team, request
from apps.docking.cycle import DockingCycle, DockingHull, DockingOrders, DockingState
from apps.docking.place import DockPlace
from apps.docking.settings import DockingSettings
from apps.echoes import echo_points
from geometry import Pose2D, Twist2D

SERVICES = ("docking",)  # for the directory, when it runs as an agent
_WATCH_PERIOD = 2.0  # s between two looks at the battery
_MISSION_TIME = 3600.0  # s; a mission of the navigation ends by itself long before
_ANSWER_TIME = 1.0  # s for a reading; without it the robot stands
_RETURN_TIME = 10.0  # s that the robot may refuse to drive, since another program has the lease
_AWAY_TIME = 20.0  # s that a sensor's agent may be away, as while a device is connected again on a loaded machine
_STATE = ["has not begun"]  # what it does, in words


def main(
    team: Team,
    robot: str = "",
    dock: str | list[float] = "",
    leave: bool = False,
    below: float = 0.0,
    until: float = 0.95,
    station: bool = True,
    settings: str = "",
) -> None:
    """Drive onto a dock and charge the battery; or leave the dock.

    Args:
        team: The robots on the bus.
        robot: Its name; any robot with a charger if empty.
        dock: Pose of the robot on its dock in its frame `odom`, as `[x,y,heading]`: m, m, rad. Or the name of a dock on
            the map on which the robot is localized.
        leave: Leave the dock; that is all.
        below: Wait until the battery is no fuller than this, 0 to 1; then dock, charge it, leave the dock, and wait
            again. Dock at once and only once if 0.
        until: How full the battery is to be, 0 to 1, when the robot leaves the dock again.
        station: The dock has a station that the laser sees.
        settings: A file with changes of `settings.toml`.
    Raises:
        RobotError: An argument is not valid, the robot or an element is missing, or the docking has failed.
    """
    try:
        tuned = DockingSettings.load(settings)
    except configs.ConfigError as err:
        raise RobotError(str(err)) from err
    elements = ("base", "battery", "charger", *(["laser"] if station and not leave else []))
    docking = _Docking(team, team.robot(robot, having=elements), tuned, station)
    try:
        if leave:
            docking.leave()
        elif not below:
            docking.dock(DockPlace(team, docking.robot.name, dock))
        else:
            _keep_charged(docking, DockPlace(team, docking.robot.name, dock), below, until)
    finally:
        _STATE[0] = "has ended"


@request("status")
def status() -> dict[str, Any]:
    """Return what the robot does, in words."""
    return {"does": _STATE[0]}


def _keep_charged(docking: "_Docking", dock: DockPlace, below: float, until: float) -> None:
    """Dock whenever the battery is low, until the program is to end."""
    if not 0.0 < below < until <= 1.0:
        raise RobotError(f"0 < below < until <= 1 is needed, not below={below:g} and until={until:g}")
    if docking.robot.battery.read().fraction is None:
        raise RobotError(
            f"{docking.robot.name} does not report how full its battery is, so below=... cannot be watched"
        )
    while docking.waits_for_battery(lambda fraction: fraction <= below, f"waits for a battery below {below:.0%}"):
        docking.dock(dock, priority=docking.settings.priority)
        if not docking.waits_for_battery(lambda fraction: fraction >= until, f"charges up to {until:.0%}"):
            return
        docking.leave()


class _Docking:
    """One robot that docks: reads it, steps a cycle, drives it."""

    def __init__(self, team: Team, robot: Robot, settings: DockingSettings, station: bool) -> None:
        self.robot, self.settings = robot, settings
        self._team, self._station = team, station
        size = robot.base.properties["geometry"]
        self._hull = DockingHull(float(size["length_front"]), float(size["width"]))
        self._laser = robot.laser if robot.has("laser") else None
        self._bumpers = robot.bumpers if robot.has("bumpers") else None
        place = {} if self._laser is None else self._laser.properties.get("geometry", {})
        self._mount = Pose2D(place.get("x", 0.0), place.get("y", 0.0), place.get("heading", 0.0))
        self._told = ""
        self._contact = False
        self._obeyed_at = time.monotonic()  # when the robot last did as it was told
        self._away_since = math.inf  # s of the present run; infinite while the agents of all sensors are there

    def dock(self, dock: DockPlace, priority: int | None = None) -> None:
        """Drive onto a dock and begin to charge.

        Args:
            dock: Where it is.
            priority: Of the lease on the base that is held meanwhile; None for no lease.
        Raises:
            RobotError: It has failed.
        """
        self._navigate(dock.pose())
        cycle = DockingCycle(self.settings, dock.pose(), self._hull, needs_station=self._station)
        with nullcontext() if priority is None else self.robot.base.lease(priority):
            self._run(cycle)

    def leave(self) -> None:
        """Leave the dock.

        Raises:
            RobotError: It has failed.
        """
        self._run(DockingCycle(self.settings, Pose2D(), self._hull, leaves=True))

    def _navigate(self, dock: Pose2D) -> None:
        """Send the robot to the place before a dock, if its indoor navigation runs.

        Raises:
            RobotError: It does not get there.
        """
        interface = f"user_interface@{self.robot.name}"
        before = dock.compose(Pose2D(-self.settings.approach.away_m, 0.0, 0.0))
        try:
            begun = self._team.ask(interface, "go", x=before.x, y=before.y, heading=before.heading)
        except NotThere:  # without a navigation the robot drives by its own means
            return
        self._tell("navigates to the place before the dock")
        try:
            ended = self._team.ask(interface, "wait", within=_MISSION_TIME, mission=begun["mission"])
        except BaseException:  # Ctrl-C, or the program is to end
            with suppress(RobotError, Stopped):  # the mission ends at the place before the dock in any case
                self._team.ask(interface, "cancel")
            raise
        if ended["state"] != "done":
            raise RobotError(f"{self.robot.name} has not got to its dock: {ended['why'] or ended['state']}")

    def waits_for_battery(self, is_met: Callable[[float], bool], words: str) -> bool:
        """Wait until the battery is so full; returns False where the program is to end before."""
        self._tell(words)
        for _ in self._team.every(_WATCH_PERIOD):
            with suppress(RobotError):  # the robot is away for a moment
                fraction = self.robot.battery.read().fraction
                if fraction is not None and is_met(fraction):
                    return True
        return False

    def _run(self, cycle: DockingCycle) -> None:
        self._obeyed_at = time.monotonic()
        self._away_since = math.inf
        next_report = self.settings.report_s
        try:
            for now in self._team.every(self.settings.period_s):
                orders = self._step(cycle, now)
                if orders is not None and (orders.changed or now >= next_report):
                    self._tell(f"{orders.state}: {orders.reason}")
                    next_report = now + self.settings.report_s
                if cycle.has_ended:
                    break
        finally:
            with suppress(RobotError, Stopped):  # it stands anyway when nobody drives it
                self.robot.base.stop()
        if cycle.state is DockingState.GIVEN_UP:
            raise RobotError(f"{self.robot.name} has given up: {cycle.reason}")

    def _step(self, cycle: DockingCycle, now: float) -> DockingOrders | None:
        """Read, decide and drive; returns what was decided, None where the robot does not answer and so stands.

        Raises:
            RobotError: The base is away, after which odometry may begin elsewhere, or another element for too long.
        """
        robot, base = self.robot, None
        try:
            base = robot.base.read(within=_ANSWER_TIME)
            if self._laser is not None:
                scan = self._laser.read(within=_ANSWER_TIME)
                points = echo_points(np.array(scan.ranges), scan.angle_min, scan.angle_increment, self._mount)
                cycle.take_scan(scan.stamp, points, base.pose)
            if self._bumpers is not None:
                bumpers = self._bumpers.read(within=_ANSWER_TIME)
                self._contact |= bumpers.pressed or bumpers.stall_left or bumpers.stall_right
            charging = robot.battery.read(within=_ANSWER_TIME).charging
        except RobotError as err:
            if isinstance(err, NotThere):
                self._away_since = min(self._away_since, now)
                if base is None or now - self._away_since > _AWAY_TIME:
                    raise RobotError(f"{robot.name} is lost while it docks: {err}") from err
            self._tell(f"stands: {err}")
            robot.base.drive(0.0, 0.0)
            return None
        self._away_since = math.inf
        orders = cycle.step(base.stamp, base.pose, charging=charging, contact=self._contact)
        self._contact = False
        if orders.contacts is not None:
            robot.base.stop()
            robot.element("charger").ask("charge", on=orders.contacts)
            if not orders.contacts:
                robot.base.enable()  # lowered contacts have the motors off
        self._drive(orders.twist)
        return orders

    def _drive(self, twist: Twist2D | None) -> None:
        """Drive; a lease of another program is waited for, as that of the navigation that has just ended.

        Raises:
            RobotError: The robot refuses for longer than that.
        """
        if twist is None:
            return
        try:
            self.robot.base.drive(twist.linear, twist.angular)
            self._obeyed_at = time.monotonic()
        except Failed:  # it is stalled
            self._contact = True
        except Refused as err:
            if time.monotonic() - self._obeyed_at > _RETURN_TIME:
                raise
            self._tell(f"waits: {err}")

    def _tell(self, words: str) -> None:
        """Print what the robot does, when it is something else."""
        _STATE[0] = words
        if words != self._told:
            self._told = words
            print(f"{self.robot.name}: {words}", flush=True)

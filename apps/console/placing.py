"""Where the frames odom of robots are on the map.

The origin of `<robot>/odom` is where the robot stood when its gateway first connected, so the frames of two robots have
nothing to do with each other. They are placed by the emulator, which knows where its robots are, or else by the starts
in the team's file. A robot that is localized, or that builds a map, is shown where that puts it; the frame `map` is
placed once, by where the robot is then. If it is localized on the file whose walls are drawn, the frames are the same:
the first pose of a localization is off by some degrees, and so would be all that is drawn of its map.
"""

from collections.abc import Mapping
from math import hypot, inf
from pathlib import Path

from apps.console.emulator import EmulatorControl, EmulatorRefused
from apps.console.robots import WatchedRobot
from geometry import Pose2D

_AGAIN = 1.0  # s between two looks at whether a robot was put elsewhere
_SAME_PLACE, _SAME_HEADING = 1.5, 0.3  # m and rad from the drawn map within which a map of its name is that map


class FramePlaces:
    """The places of the frames. changes: counts the changes."""

    def __init__(self, starts: Mapping[str, tuple[float, float, float]], map_file: str = "") -> None:
        """Begin.

        Args:
            starts: Of the team's file: x and y, m, and heading, rad, by robot.
            map_file: Name of the map file whose walls are drawn; empty for another kind of floor.
        """
        self._map_file = map_file
        self.changes = 0
        self._by_file = {robot: Pose2D(*start) for robot, start in starts.items()}
        # By robot: identity of the gateway and number of the time that it was put elsewhere, for which the place holds.
        self._by_emulator: dict[str, tuple[tuple[str, int], Pose2D]] = {}
        self._again_at = -inf
        self._maps: dict[str, tuple[str, Pose2D]] = {}  # by robot: its map, and the place of that on this one
        self._in_map: dict[str, Pose2D] = {}  # frame odom in the frame of that map

    def of(self, robot: str) -> Pose2D | None:
        """Return the place of a robot's frame odom on the map; None if it is not known."""
        if robot in self._in_map:
            return self._maps[robot][1].compose(self._in_map[robot])
        return self._of_start(robot)

    def map_of(self, robot: str) -> Pose2D:
        """Return the place of the frame `map` of a robot; the origin if nothing else is known."""
        return self._maps[robot][1] if robot in self._maps else Pose2D()

    def locate(self, robot: str, name: str, odom_in_map: Pose2D | None) -> None:
        """Note where a robot's frame odom is in the frame of its map.

        Args:
            robot: Which.
            name: Of its map.
            odom_in_map: None if it is not to be believed; then the latest one stays.
        """
        if odom_in_map is None:
            return
        if self._maps.get(robot, ("",))[0] != name:
            begun = self._of_start(robot)
            place = begun.compose(Pose2D().relative_to(odom_in_map)) if begun is not None else Pose2D()
            self._maps[robot] = name, Pose2D() if self._is_drawn(name, place) else place
        self._in_map[robot] = odom_in_map

    def forget(self, robot: str) -> None:
        """Show a robot by its odometry again, since it is not localized any more."""
        self._in_map.pop(robot, None)

    def _is_drawn(self, name: str, place: Pose2D) -> bool:
        """Return whether a map is the one that is drawn, by its file's name and its place by the first pose."""
        is_near = hypot(place.x, place.y) <= _SAME_PLACE and abs(place.heading) <= _SAME_HEADING
        return is_near and bool(self._map_file) and Path(name).name == self._map_file

    def _of_start(self, robot: str) -> Pose2D | None:
        found = self._by_emulator.get(robot)
        return found[1] if found is not None else self._by_file.get(robot)

    def words(self, robots: Mapping[str, WatchedRobot]) -> str:
        """Return how the robots are placed, a sentence for people."""
        there = [name for name, robot in robots.items() if robot.is_there]
        located = [name for name in there if name in self._in_map]
        unknown = [name for name in there if self.of(name) is None]
        if not there:
            return "No robot is on the bus yet; the map shows robots as they come."
        if located and not unknown:
            verb = "is" if len(located) == 1 else "are"
            return f"{' and '.join(located)} {verb} shown where the map puts {'it' if verb == 'is' else 'them'}."
        if not unknown:
            how = "the emulator says" if all(name in self._by_emulator for name in there) else "the team's file says"
            return f"Robots are placed where {how} that they began."
        if len(there) == 1:
            return f"{unknown[0]} is shown in its own frame: the origin is where it began."
        who = "Each robot" if len(unknown) == len(there) else " and ".join(unknown)
        verb = "is" if len(unknown) == len(there) or len(unknown) == 1 else "are"
        return (
            f"{who} {verb} shown in a frame of its own, with the origin where it began: distances between such robots "
            "mean nothing. Start the console with --team to place them."
        )

    async def ask(
        self, emulator: EmulatorControl, robots: Mapping[str, WatchedRobot], now: float, *, is_watched: bool
    ) -> None:
        """Ask the emulator for the places of emulated robots that are not known yet, or have changed.

        They change with a gateway, whose odometry begins anew, and when somebody puts the robot somewhere else.

        Args:
            emulator: Whose robots they may be.
            robots: All that are known.
            now: s of a steady clock.
            is_watched: Whether somebody looks; otherwise only robots are asked for that are not known yet.
        """
        emulated = {name: robot for name, robot in robots.items() if robot.is_emulated and robot.is_connected}
        identities = {name: str(robot.description.get("identity", "")) for name, robot in emulated.items()}
        is_new = any(self._identity(name) != identity for name, identity in identities.items())
        if not emulated or not (is_new or (is_watched and now >= self._again_at)):
            return
        self._again_at = now + _AGAIN
        try:
            rows = (await emulator.ask("truth"))["robots"]
        except EmulatorRefused:  # it is being ended; the page Faults says so
            return
        for name, robot in emulated.items():
            row, pose = rows.get(name), robot.pose
            if row is None or pose is None:  # no robot of this emulator, or it has not said where it is
                continue
            known = self._by_emulator.get(name)
            state = identities[name], int(row.get("placed", 0))
            if known is None or known[0] != state:
                there = Pose2D(row["x"], row["y"], row["heading"])
                self._by_emulator[name] = state, there.compose(Pose2D().relative_to(Pose2D(*pose)))
                self.changes += 1

    def _identity(self, robot: str) -> str | None:
        known = self._by_emulator.get(robot)
        return known[0][0] if known is not None else None

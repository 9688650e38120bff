"""Output of a team during its start: each robot when it is ready, and regularly what the others wait for."""

from collections.abc import Callable, Sequence

from acromovi.team.readiness import Readiness, RobotReadiness

SOONEST = 2.0  # s after another line
LATEST = 10.0  # s after which the same line is printed again


class ProgressLines:
    """Prints the progress of a team, one line at a time.

    told: the robots that were reported to serve.
    """

    def __init__(self, readiness: Readiness, robots: int, tell: Callable[[str], None], begun: float) -> None:
        """Begin.

        Args:
            readiness: Of the robots.
            robots: How many there are.
            tell: Prints a line.
            begun: When the team began, s of the steady clock.
        """
        self.told: set[str] = set()
        self._readiness = readiness
        self._robots = robots
        self._tell = tell
        self._begun = self._told_at = begun
        self._waiting = ""

    def look(self, serving: Sequence[str], late: Sequence[str], now: float) -> None:
        """Print what is new.

        Args:
            serving: Robots that serve.
            late: Robots that do not yet, and are waited for.
            now: s of the steady clock.
        """
        for robot in serving:
            if robot not in self.told:
                self.told.add(robot)
                self._print(self._ready(robot, self._readiness[robot], now), now)
        waiting = self._awaited(late) if late else "the team's own agents"
        if waiting and now - self._told_at >= (SOONEST if waiting != self._waiting else LATEST):
            self._waiting = waiting
            self._print(f"waiting for {waiting}", now)

    def _awaited(self, late: Sequence[str]) -> str:
        """What robots wait for, those that wait for the same together: `gateway (happy, doc), laser (max)`."""
        wanted: dict[str, list[str]] = {}
        for name in late:
            wanted.setdefault(self._readiness[name].awaited, []).append(name)
        wanted.pop("", None)
        return ", ".join(f"{what} ({', '.join(names)})" for what, names in wanted.items())

    def _ready(self, robot: str, progress: RobotReadiness, now: float) -> str:
        without = f", without {', '.join(progress.missing())}" if progress.missing() else ""
        count = f"{len(self.told)} of {self._robots}"
        return f"{robot} serves after {now - self._begun:.1f} s, {count}: {', '.join(sorted(progress.agents))}{without}"

    def _print(self, line: str, now: float) -> None:
        self._told_at = now
        self._tell(line)

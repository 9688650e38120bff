"""Why a robot of a team is not ready: a few words during the start, and the cause after a timeout."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from acromovi.team.plan import SERVICES, ProcessKind
from acromovi.team.readiness import RobotReadiness
from acromovi.team.supervisor import ProcessRow, ProcessState
from configs.team_file import TeamRobot


class Causes:
    """What the processes of a team have reported so far, and what is wrong by that."""

    def __init__(self, table: Sequence[ProcessRow], reports: Mapping[str, str]) -> None:
        """Take the reports.

        Args:
            table: The team's processes.
            reports: What was reported last, by the name of the program, or of the robot that its gateway tells of.
        """
        self._table = table
        self._reports = reports

    def of(self, robot: TeamRobot, progress: RobotReadiness) -> str:
        """Return why a robot does not serve, as far as it can be known.

        Args:
            robot: As the team's file has it.
            progress: How far it has come.
        """
        gateway = self._row(ProcessKind.GATEWAY, robot.name)
        if robot.is_emulated:
            emulator = self._row(ProcessKind.EMULATOR, "")
            if emulator is None or emulator.state is not ProcessState.RUNNING or gateway is None:
                return self._process("the emulator", emulator, "has not reported its ports")
        elif "://" not in robot.port and not Path(robot.port).exists():
            return f"there is no port {robot.port}; plug the robot in, or correct its port in the team's file"
        if not progress.is_in_touch:
            waits = "has lost the robot" if progress.is_lost else "has not connected to the robot"
            return self._process("its gateway", gateway, waits, robot.name)
        if not progress.container_serves:
            return self._process("its container", self._row(ProcessKind.AGENTS, robot.name), "does not answer")
        if missing := sorted(progress.parts - progress.agents):
            return f"its {' and its '.join(missing)} did not answer; correct fit in the team's file, or check the cable"
        return "its container has started no agent" if not progress.agents else "its agents still come and go"

    def of_services(self) -> str:
        """Return why the container of the team's own agents does not serve."""
        entry = next((entry for entry in self._table if entry.program.container == SERVICES), None)
        return self._process("their container", entry, "does not answer")

    def _process(self, what: str, entry: ProcessRow | None, waits: str, robot: str = "") -> str:
        """Return what is wrong with a process. waits: what to say of one that runs. robot: the one that it is about."""
        if entry is None:
            return f"{what} has not been started yet"
        report = self._reports.get(robot) or self._reports.get(entry.program.name, "")
        if entry.state is ProcessState.RUNNING and not entry.ends:
            pid = "" if entry.child is None else f" (process {entry.child.pid})"
            return f"{what}{pid} {waits}{': ' if report else ''}{report}"
        if not entry.why:
            return f"{what} is being started"
        times = f" {entry.ends} times" if entry.ends > 1 else ""
        why = entry.why if entry.why.startswith("ended") else f"ended: {plain(entry.why)}"
        return f"{what} {why.replace('ended', f'ended{times}', 1)}"

    def _row(self, stage: ProcessKind, robot: str) -> ProcessRow | None:
        """Return the process of a stage that serves the robot, its own before a shared one.

        Of its containers it is the one that is called as the robot is.
        """
        wanted = [
            entry for entry in self._table if entry.program.stage is stage and robot in (*entry.program.robots, "")
        ]
        if stage is ProcessKind.AGENTS:
            wanted = [entry for entry in wanted if entry.program.container == robot]
        return min(wanted, key=lambda entry: len(entry.program.robots), default=None)


def plain(sentence: str) -> str:
    """Return the complaint of a program without the program's name."""
    name, colon, rest = sentence.partition(": ")
    return rest if colon and name in ("p2os-emu", "p2os-gateway", "acromovi container") else sentence

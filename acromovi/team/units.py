"""Units of systemd that start a robot's gateway and agents when its own computer boots, without a team."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from acromovi.team.identities import TeamOptions
from acromovi.team.plan import PlannedProcess, ProcessKind, TeamPlan, TeamProcesses
from configs import ConfigError

RESTART_AFTER = 2  # s; a gateway waits for its robot by itself, so it ends on errors only
ENDING_TIME = 10  # s from SIGTERM to SIGKILL; a gateway stops its robot first
UNIT = """\
# Written by acromovi up --units. Enable it with: systemctl --user enable --now {file}
[Unit]
Description={description}
{after}StartLimitIntervalSec=0

[Service]
ExecStart={command}
WorkingDirectory={folder}
Restart=always
RestartSec={restart}
TimeoutStopSec={ending}

[Install]
WantedBy=default.target
"""


@dataclass(frozen=True, slots=True)
class WrittenUnits:
    """What was written. units: names of the units. files: all files."""

    units: Sequence[str]
    files: Sequence[Path]


def write_units(team: TeamPlan, choices: TeamOptions, folder: Path) -> WrittenUnits:
    """Write a unit for each process of each real robot, and the settings of its gateway.

    Args:
        team: The team; its emulated robots are left out.
        choices: Of the command line.
        folder: For the files; it is created.
    Raises:
        ConfigError: The team has no real robot, or one of its names cannot be that of a unit.
        OSError: The files cannot be written.
    """
    real = [robot for robot in team.robots if not robot.is_emulated]
    if not real:
        raise ConfigError(f"{team.source}: no robot here is real, so there is nothing to start when a computer boots")
    folder = folder.absolute()
    folder.mkdir(parents=True, exist_ok=True)
    processes = TeamProcesses(replace(team, file=replace(team.file, robots=tuple(real))), choices, folder)
    processes.write_settings()
    settings = [folder / f"{robot.name}.toml" for robot in real]
    units, files = [], [path for path in settings if path.exists()]
    for robot in real:
        gateway = processes.gateway(robot, {})
        programs = [gateway, processes.container(robot.name)]
        if robot.navigation:
            programs += processes.navigation(robot.name)
        for program in programs:
            file = folder / _file_of(program)
            file.write_text(_text(program, gateway, folder, file.name), encoding="utf-8")
            units.append(file.name)
            files.append(file)
    return WrittenUnits(units, files)


def _file_of(program: PlannedProcess) -> str:
    what = "gateway" if program.stage is ProcessKind.GATEWAY else "agents"
    name = program.robot if program.stage is ProcessKind.GATEWAY else program.container
    escaped = "".join(each if each.isascii() and (each.isalnum() or each in "_-.") else "_" for each in name)
    return f"acromovi-{what}-{escaped}.service"


def _text(program: PlannedProcess, gateway: PlannedProcess, folder: Path, file: str) -> str:
    after = "" if program is gateway else f"After={_file_of(gateway)}\n"
    return UNIT.format(
        file=file,
        description=f"Acromovi: {program.name}".replace("%", "%%"),
        after=after,
        command=" ".join(map(_quoted, program.command)),
        folder=str(folder).replace("%", "%%"),
        restart=RESTART_AFTER,
        ending=ENDING_TIME,
    )


def _quoted(word: str) -> str:
    """A word of a command line for systemd, see systemd.service(5): quotes, and no variables or specifiers."""
    escaped = word.replace("\\", "\\\\").replace('"', '\\"').replace("%", "%%").replace("$", "$$")
    return (
        f'"{escaped}"' if escaped != word or not word or any(each.isspace() or each in "';" for each in word) else word
    )

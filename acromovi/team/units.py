"""Units of systemd that start a robot's gateway and agents when its own computer boots, without a team."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from acromovi.team.identities import TeamOptions
from acromovi.team.plan import WRITTEN, PlannedProcess, ProcessKind, TeamPlan, TeamProcesses
from configs import ConfigError

RESTART_AFTER = 2  # s; a gateway waits for its robot by itself, so it ends on errors only
ENDING_TIME = 10  # s from SIGTERM to SIGKILL; a gateway stops its robot first
UNIT = """\
{written} --units. Enable it with: systemctl --user enable --now {file}
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
        ConfigError: The team has no real robot, or a file of another origin has the name of one to write; nothing is
            written then.
        OSError: The files cannot be written.
    """
    real = [robot for robot in team.robots if not robot.is_emulated]
    if not real:
        raise ConfigError(f"{team.source}: no robot here is real, so there is nothing to start when a computer boots")
    folder = folder.absolute()
    processes = TeamProcesses(replace(team, file=replace(team.file, robots=tuple(real))), choices, folder)
    texts = processes.settings()
    units = []
    for robot in real:
        gateway = processes.gateway(robot, {})
        programs = [gateway, processes.container(robot.name)]
        if robot.navigation:
            programs += processes.navigation(robot.name)
        for program in programs:
            file = folder / _file_of(program)
            texts[file] = _text(program, gateway, folder, file.name)
            units.append(file.name)
    for file in texts:
        _check_origin(file)
    folder.mkdir(parents=True, exist_ok=True)
    for file, text in texts.items():
        file.write_text(text, encoding="utf-8")
    return WrittenUnits(units, list(texts))


def _check_origin(file: Path) -> None:
    """Check that a file is not there, or was written by this command."""
    if file.exists() and not file.read_bytes().startswith(WRITTEN.encode()):
        raise ConfigError(f"{file} was not written by this command and is kept; move it, or give another folder")


def _file_of(program: PlannedProcess) -> str:
    what = "gateway" if program.stage is ProcessKind.GATEWAY else "agents"
    name = program.robot if program.stage is ProcessKind.GATEWAY else program.container
    escaped = "".join(each if each.isascii() and (each.isalnum() or each in "_-.") else "_" for each in name)
    return f"acromovi-{what}-{escaped}.service"


def _text(program: PlannedProcess, gateway: PlannedProcess, folder: Path, file: str) -> str:
    after = "" if program is gateway else f"After={_file_of(gateway)}\n"
    return UNIT.format(
        written=WRITTEN,
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

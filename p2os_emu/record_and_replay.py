"""Recordings in `p2os-emu`: record its robots, serve a recorded robot, compare a recording with an emulated robot."""

import contextlib
import json
import time
from collections import Counter
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import configs
from p2os import RobotModel
from p2os_emu.checking import RecordingDifference, compare, replay
from p2os_emu.emulator import STEP, EmulatedRobot
from p2os_emu.fit import FitError, read_fit
from p2os_emu.links.line import EmulatedLine, LinkProfile
from p2os_emu.links.poller import Poller
from p2os_emu.options import EmulatorOptions
from p2os_emu.ports import Ports
from p2os_emu.recording import LineRecorder, Recording, RecordingError, ReplayDevice, read
from p2os_emu.runner import Runner
from p2os_emu.surroundings import EmulatedSurroundings


class RobotRecorders:
    """Puts a recorder on the line of every robot: the first and only one writes `path`, of several each PATH-NAME.

    A robot whose name another one had before, in the same run, writes PATH-NAME-2 and so on.

    Args:
        path: Where to write.
        robots: How many robots there are from the start.
        force: Overwrite files that exist.
    """

    def __init__(self, path: Path, robots: int, *, force: bool = False) -> None:
        self._force = force
        self._uses: Counter[str] = Counter()
        self._path = path
        self._is_alone = robots == 1
        self._recorders: list[LineRecorder] = []

    def add(self, robot: EmulatedRobot) -> None:
        """Record a robot from now on.

        Raises:
            RecordingError: The file exists, or cannot be written.
        """
        plain = self._is_alone and not self._recorders
        name = self._path.name if plain else f"{self._path.name}-{robot.name}"
        self._uses[name] += 1
        if self._uses[name] > 1:
            name = f"{name}-{self._uses[name]}"
        path = self._path.with_name(name)
        recorder = LineRecorder(path, robot.name, robot.model.name, force=self._force)
        self._recorders.append(recorder)
        robot.line.tap = recorder

    def close(self) -> None:
        """End every file."""
        for recorder in self._recorders:
            recorder.close()


class _ServedRobot:
    """A player on a line; a runner moves it as it moves an emulator.

    time: s since the start. silence: as that of an emulator; what is on the recording is sent at its step.
    """

    silence = 0.0

    def __init__(self, player: ReplayDevice, line: EmulatedLine) -> None:
        self.time = 0.0
        self._player = player
        self._line = line

    def step(self) -> None:
        """Let `STEP` pass."""
        data = self._line.receive(self.time, self._player.baud)
        if data:
            self._player.receive(data)
        said = self._player.step(STEP)
        self.time += STEP
        self._line.send(said, self.time, self._player.baud)


def serve(path: Path, options: EmulatorOptions) -> None:
    """Serve a recorded robot to clients until the duration is over or a signal ends the program.

    Raises:
        RecordingError, ConfigError, PortError: As usual.
    """
    recording = read(path)
    profile = configs.load(LinkProfile, "links", options.link)
    with ExitStack() as stack:
        poller = stack.enter_context(contextlib.closing(Poller()))
        link = stack.enter_context(
            contextlib.closing(Ports(poller, pty=options.pty, tcp=options.tcp).open(recording.name))
        )
        robot = _ServedRobot(ReplayDevice(recording), EmulatedLine(link, profile, options.seed))
        runner = Runner(robot, poller, clock=time.monotonic, sleep=time.sleep, speed=options.speed)
        _announce(recording, link.port, path, options)
        runner.run(options.duration)


def check(recording: Recording, path: Path, options: EmulatorOptions, world: EmulatedSurroundings) -> bool:
    """Send a recorded client's bytes to the emulator, and print the differences between the two robots.

    Returns:
        Whether they agree.
    Raises:
        RecordingError, ConfigError: As usual; also when nothing says which model it was.
    """
    model = configs.load(RobotModel, "robots", _model(recording, path, options))
    try:
        model, fit = read_fit([part for text in options.fits for part in text.split(",")], model)
    except FitError as error:
        raise RecordingError(str(error)) from error
    said = replay(recording, model, world, fit, options.seed, as_simulator=options.as_simulator)
    differences = compare(recording.moments, said, model)
    for difference in differences:
        print(json.dumps({"parting": difference.as_json()}) if options.json else difference)
    _sum_up(differences, recording, model, options)
    return not differences


def _model(recording: Recording, path: Path, options: EmulatorOptions) -> str:
    if options.robots:
        return options.robots[0]
    name = recording.identity.subtype if recording.identity else recording.model
    if not name:
        raise RecordingError(f"{path} does not say which model it was; give --robot MODEL")
    return name


def _sum_up(
    differences: list[RecordingDifference], recording: Recording, model: RobotModel, options: EmulatorOptions
) -> None:
    kinds = sorted({difference.kind for difference in differences})
    if options.json:
        print(json.dumps({"same": not differences, "model": model.name, "partings": len(differences), "kinds": kinds}))
    elif not options.quiet:
        seconds = recording.moments[-1].time - recording.moments[0].time
        ways = "1 way" if len(differences) == 1 else f"{len(differences)} ways"
        verdict = f"part in {ways} ({', '.join(kinds)})" if differences else "are the same"
        print(f"{seconds:.1f} s of a {model.name}: recording and emulator {verdict}")


def _announce(recording: Recording, port: str, path: Path, options: EmulatorOptions) -> None:
    identity = recording.identity
    name = identity.name if identity else recording.name
    model = identity.subtype if identity else recording.model
    absent = {"laser_port": None, "arm_port": None, "camera_url": None}
    entry: dict[str, Any] = {"name": name, "model": model, "port": port, "link": options.link} | absent
    if options.json:
        print(json.dumps({"robots": [entry], "control": None}), flush=True)
    elif not options.quiet:
        print(f"{name or 'A robot'}, as recorded on {path}, is on {port}\nCtrl-C ends it.", flush=True)

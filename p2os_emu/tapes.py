"""What `p2os-emu` does with cassettes: record its robots, serve a recorded one, check a recording against its own."""

import contextlib
import json
import time
from collections import Counter
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import configs
from p2os import RobotModel
from p2os_emu.cassette import Cassette, CassetteError, Player, Recorder, read
from p2os_emu.checking import Parting, compare, replay
from p2os_emu.emulator import STEP, EmulatedRobot
from p2os_emu.fit import FitError, read_fit
from p2os_emu.links.line import EmulatedLine, LinkProfile
from p2os_emu.links.poller import Poller
from p2os_emu.options import EmulatorOptions
from p2os_emu.ports import Ports
from p2os_emu.runner import Runner
from p2os_emu.surroundings import EmulatedSurroundings


class Recording:
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
        self._recorders: list[Recorder] = []

    def add(self, robot: EmulatedRobot) -> None:
        """Record a robot from now on.

        Raises:
            CassetteError: The file exists, or cannot be written.
        """
        plain = self._is_alone and not self._recorders
        name = self._path.name if plain else f"{self._path.name}-{robot.name}"
        self._uses[name] += 1
        if self._uses[name] > 1:
            name = f"{name}-{self._uses[name]}"
        path = self._path.with_name(name)
        recorder = Recorder(path, robot.name, robot.model.name, force=self._force)
        self._recorders.append(recorder)
        robot.line.tap = recorder

    def close(self) -> None:
        """End every file."""
        for recorder in self._recorders:
            recorder.close()


class ServedRobot:
    """A player on a line; a runner moves it as it moves an emulator.

    time: s since the start. silence: as that of an emulator; what is on the recording is sent at its step.
    """

    silence = 0.0

    def __init__(self, player: Player, line: EmulatedLine) -> None:
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
    """Let clients meet the robot on a cassette, until the duration is over or a signal ends the program.

    Raises:
        CassetteError, ConfigError, PortError: As usual.
    """
    cassette = read(path)
    profile = configs.load(LinkProfile, "links", options.link)
    with ExitStack() as stack:
        poller = stack.enter_context(contextlib.closing(Poller()))
        link = stack.enter_context(
            contextlib.closing(Ports(poller, pty=options.pty, tcp=options.tcp).open(cassette.name))
        )
        robot = ServedRobot(Player(cassette), EmulatedLine(link, profile, options.seed))
        runner = Runner(robot, poller, clock=time.monotonic, sleep=time.sleep, speed=options.speed)
        _announce(cassette, link.port, path, options)
        runner.run(options.duration)


def check(path: Path, options: EmulatorOptions, world: EmulatedSurroundings) -> bool:
    """Play a cassette's client to the emulator, and print where the two robots part.

    Returns:
        Whether they agree.
    Raises:
        CassetteError, ConfigError: As usual; also when nothing says which model it was.
    """
    cassette = read(path)
    model = configs.load(RobotModel, "robots", _model(cassette, path, options))
    try:
        model, fit = read_fit([part for text in options.fits for part in text.split(",")], model)
    except FitError as error:
        raise CassetteError(str(error)) from error
    said = replay(cassette, model, world, fit, options.seed, as_simulator=options.as_simulator)
    partings = compare(cassette.moments, said, model)
    for parting in partings:
        print(json.dumps({"parting": parting.as_json()}) if options.json else parting)
    _sum_up(partings, cassette, model, options)
    return not partings


def _model(cassette: Cassette, path: Path, options: EmulatorOptions) -> str:
    if options.robots:
        return options.robots[0]
    name = cassette.identity.subtype if cassette.identity else cassette.model
    if not name:
        raise CassetteError(f"{path} does not say which model it was; give --robot MODEL")
    return name


def _sum_up(partings: list[Parting], cassette: Cassette, model: RobotModel, options: EmulatorOptions) -> None:
    kinds = sorted({parting.kind for parting in partings})
    if options.json:
        print(json.dumps({"same": not partings, "model": model.name, "partings": len(partings), "kinds": kinds}))
    elif not options.quiet:
        seconds = cassette.moments[-1].time - cassette.moments[0].time
        ways = "1 way" if len(partings) == 1 else f"{len(partings)} ways"
        verdict = f"part in {ways} ({', '.join(kinds)})" if partings else "are the same"
        print(f"{seconds:.1f} s of a {model.name}: recording and emulator {verdict}")


def _announce(cassette: Cassette, port: str, path: Path, options: EmulatorOptions) -> None:
    identity = cassette.identity
    name = identity.name if identity else cassette.name
    model = identity.subtype if identity else cassette.model
    absent = {"laser_port": None, "arm_port": None, "camera_url": None}
    entry: dict[str, Any] = {"name": name, "model": model, "port": port, "link": options.link} | absent
    if options.json:
        print(json.dumps({"robots": [entry], "control": None}), flush=True)
    elif not options.quiet:
        print(f"{name or 'A robot'}, as recorded on {path}, is on {port}\nCtrl-C ends it.", flush=True)

"""Builds the emulated robots that the command line asks for, and runs them."""

import contextlib
import ctypes
import json
import os
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

import configs
from configs.extras import ExtraMissing
from configs.startup import uncollected
from p2os_emu.control import ControlSocket
from p2os_emu.control_requests import ControlRequestHandler
from p2os_emu.degradation import STAGES
from p2os_emu.emulator import Emulator
from p2os_emu.factory import Factory
from p2os_emu.faults.board import FaultBoard
from p2os_emu.links.line import LinkProfile
from p2os_emu.links.link import PortError
from p2os_emu.links.poller import HUNG_UP, Poller
from p2os_emu.options import EXIT_OK, EXIT_PARTS, EmulatorOptions, PhysicsError
from p2os_emu.ports import Ports
from p2os_emu.private_folder import CONTROL, private_folder
from p2os_emu.runner import Runner
from p2os_emu.team import EmulatedTeam

if TYPE_CHECKING:
    from p2os_emu.camera.cameras import Cameras
    from p2os_emu.world import World


def run(options: EmulatorOptions) -> int:
    """Do what the command line asks for; return the exit code.

    Raises:
        ConfigError: A robot, world or link does not exist, or a file has an error.
        FaultError: A robot cannot have a fault, or there is no such fault.
        PhysicsError: The engine is missing, or has no display.
        PortError: A port cannot be had.
        RecordingError: A recording cannot be read or written.
    """
    if options.check is not None:
        return _check(options.check, options)
    if options.serve is not None:
        from p2os_emu.record_and_replay import serve

        serve(options.serve, options)
    else:
        _emulate(options)
    return EXIT_OK


def _emulate(options: EmulatorOptions) -> None:
    profile = configs.load(LinkProfile, "links", options.link)
    flash = configs.read(options.flash) if options.flash else {}
    with ExitStack() as stack:
        if options.gui:
            stack.enter_context(_clean_output())
        with uncollected():
            world = stack.enter_context(contextlib.closing(_make_world(options)))
            poller = stack.enter_context(contextlib.closing(Poller()))
            emulator = Emulator(
                world,
                profile,
                seed=options.seed,
                hangup_stops=options.hangup_stops,
                as_simulator=options.as_simulator,
            )
            stack.callback(emulator.close)
            ports = Ports(poller, pty=options.pty, tcp=_first_tcp_port(options), robots=len(options.robots))
            team = EmulatedTeam(
                emulator,
                ports,
                options.link,
                flash,
                str(options.flash),
                options.fits,
                links=options.links,
            )
            if options.record is not None:
                from p2os_emu.record_and_replay import RobotRecorders

                recording = RobotRecorders(options.record, len(options.robots), force=options.force)
                stack.callback(recording.close)
                team.whenever_added.append(recording.add)
            cameras = stack.enter_context(contextlib.closing(_open_cameras(emulator, world, team)))
            robots = [team.add(text, options.places.get(text.rpartition(":")[2])) for text in options.robots]
            team.check_fits()
            faults = FaultBoard(emulator.robots)
            emulator.before_step = faults.advance
            for spec in options.faults:
                faults.schedule(spec, emulator.time)
            for path in options.fault_files:
                faults.schedule_file(path, emulator.time)
            runner = Runner(emulator, poller, clock=time.monotonic, sleep=time.sleep, speed=options.speed)
            requests = ControlRequestHandler(team, faults, runner)
            control = ControlSocket(_control_path(options, stack), poller, requests.answer)
            stack.callback(control.close)
            runner.between_steps += [control.serve, cameras.tend]
            runner.needs_each_step += [
                lambda: control.has_requests,
                lambda: cameras.are_watched,
                lambda: bool(faults.faults),
                lambda: options.gui,
            ]
            if not options.quiet:
                runner.between_steps.append(lambda: _report_load(runner))

            def degrade(level: int) -> None:
                cameras.has_stopped = level > STAGES.index("camera images")
                world.stop_people(level > STAGES.index("people"))

            runner.when_degraded.append(degrade)
            factory = _open_factory(options, poller, team, stack)
            if factory is not None:
                runner.between_steps.append(factory.tend)
            if options.until_stdin_closes:
                _end_with_stdin(poller, runner)
            _announce(options, [team.entry(robot) for robot in robots], factory, control.path)
        stack.callback(_report, options, runner)
        with world.until_window_closes():
            runner.run(options.duration)


def _check(path: Path, options: EmulatorOptions) -> int:
    from p2os_emu.record_and_replay import check
    from p2os_emu.recording import ENGINE_SPARED_FROM, PARKED_REST_FROM, SONAR_IN_PLANE_FROM, read

    with contextlib.closing(_make_world(options)) as world:
        recording = read(path)
        world.rest_parked = recording.version >= PARKED_REST_FROM
        world.engine_use.is_spared = recording.version >= ENGINE_SPARED_FROM
        world.sonar_in_plane = recording.version >= SONAR_IN_PLANE_FROM
        return EXIT_OK if check(recording, path, options, world) else EXIT_PARTS


@contextlib.contextmanager
def _clean_output() -> Iterator[None]:
    """Discard what the engine's window prints; only Python's output reaches standard output."""
    with os.fdopen(os.dup(1), "w", encoding="utf-8") as own, Path(os.devnull).open("wb") as nowhere:
        os.dup2(nowhere.fileno(), 1)
        try:
            with contextlib.redirect_stdout(own):
                yield
        finally:
            ctypes.CDLL(None).fflush(None)  # what C code has printed into its own buffers, while it still goes nowhere
            os.dup2(own.fileno(), 1)


def _make_world(options: EmulatorOptions) -> "World":
    # The engine takes longer to load than all the rest: what needs none of it should not wait for it.
    try:
        from p2os_emu.world import World, WorldError, load_world
    except ExtraMissing as error:
        raise PhysicsError(str(error)) from error
    from p2os_emu.zero_pages import zeros_given_back

    try:
        spec = load_world(options.world)
    except WorldError as error:
        raise configs.ConfigError(str(error)) from error
    if spec.note and not options.quiet:
        print(f"p2os-emu: {spec.note}", file=sys.stderr)
    try:
        with contextlib.nullcontext() if options.gui else zeros_given_back():  # a window draws in a thread
            return World(spec, seed=options.seed, perfect=options.perfect, gui=options.gui)
    except WorldError as error:
        raise PhysicsError(str(error)) from error


def _open_cameras(emulator: Emulator, world: "World", team: EmulatedTeam) -> "Cameras":
    # Here and not at the top: it knows the world, and loads the engine with it.
    from p2os_emu.camera.cameras import Cameras

    cameras = Cameras(emulator, world, lambda sentence: print(f"p2os-emu: {sentence}", file=sys.stderr))
    team.whenever_added.append(cameras.add)
    team.camera_url = cameras.url
    return cameras


def _first_tcp_port(options: EmulatorOptions) -> int | None:
    """Of the robots there are from the start; a factory's port comes before theirs."""
    return options.tcp + 1 if options.tcp and options.factory else options.tcp


def _open_factory(options: EmulatorOptions, poller: Poller, team: EmulatedTeam, stack: ExitStack) -> Factory | None:
    if options.factory is None:
        return None
    team.check_model(options.factory)
    factory = Factory(poller, team, options.factory, options.tcp or 0)
    stack.callback(factory.close)
    return factory


def _end_with_stdin(poller: Poller, runner: Runner) -> None:
    """End the program when standard input closes."""
    try:
        poller.watch(sys.stdin.fileno(), lambda events: runner.leave(), HUNG_UP)
    except PermissionError as error:
        raise PortError("--until-stdin-closes: standard input is a file; give it a pipe that stays open") from error


def _control_path(options: EmulatorOptions, stack: ExitStack) -> Path:
    if options.control is not None:
        return options.control
    return stack.enter_context(private_folder()) / CONTROL


def _announce(options: EmulatorOptions, robots: list[dict[str, Any]], factory: Factory | None, control: Path) -> None:
    if options.json:
        ready = {"robots": robots, "control": str(control)}
        if factory is not None:
            ready["factory_port"] = factory.port
        print(json.dumps(ready), flush=True)
    elif not options.quiet:
        for robot in robots:
            print(f"{robot['name']}, a {robot['model']}, is on {robot['port']}")
            for part, key in (("laser", "laser_port"), ("arm", "arm_port"), ("camera", "camera_url")):
                if robot[key]:
                    print(f"{robot['name']}'s {part} is on {robot[key]}")
        if factory is not None:
            print(f"Every client of {factory.port} finds a {factory.model} of its own")
        if robots:
            print(f"\nConnect any client to it, or drive it from the bus:  p2os-gateway {robots[0]['port']}")
        print(f"Control socket: {control}")
        print("Ctrl-C ends it.", flush=True)
    if options.speed != 1.0 and not options.quiet:
        print(
            f"p2os-emu: at --speed {options.speed:g} the robots' watchdogs and those of their clients no longer agree",
            file=sys.stderr,
        )


def _report_load(runner: Runner) -> None:
    sentence = runner.report()
    if sentence:
        print(f"p2os-emu: {sentence}", file=sys.stderr, flush=True)


def _report(options: EmulatorOptions, runner: Runner) -> None:
    if runner.late_dropped and not options.quiet:
        print(
            f"p2os-emu: the machine was too busy: {runner.late_dropped} steps ({runner.lost:.1f} s) were more than a "
            "second late and were dropped",
            file=sys.stderr,
        )

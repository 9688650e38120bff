"""Scenes of what flows on a cable: in words, recorded, replayed and compared; and of clients that want a simulator."""

import subprocess
import sys
import time
from collections import Counter

import serial

import configs
from acromovi.children import emulator, gateway
from acromovi.scenes.stage import Scene, SceneFailed, Stage
from bus import ZenohBus, keys
from p2os import Command, ExtendedLaser, Frame, FrameDecoder, RobotModel, UnknownPacket, decode_packet, encode_command
from p2os.wire_log import Entry, as_text

CASSETTE = "drive.jsonl"
SHOWN = 12


def _wire(stage: Stage) -> None:
    entries = _recorded(stage)
    for entry in entries[:SHOWN]:
        stage.say(as_text(entry))
    stage.say(f"... and {len(entries) - SHOWN} more frames; acromovi wire FILE shows them all")


def _recorded(stage: Stage) -> list[Entry]:
    """A short drive, read back from its cassette."""
    from acromovi.wire import replay

    stage.tell(keys.MOVE, distance=0.2)
    stage.wait(lambda: stage.truth()["x"] != 0.0 and abs(stage.truth()["linear"]) > 0.05, "a moving robot")
    entries: list[Entry] = []
    replay(stage.folder / CASSETTE, None, lambda found: entries.extend(found))
    if len(entries) <= SHOWN:
        raise SceneFailed(f"only {len(entries)} frames were recorded")
    return entries


def _cassette(stage: Stage) -> None:
    _recorded(stage)
    name = f"{stage.robot}-tape"[-19:]
    with emulator("--quiet", "--serve", str(stage.folder / CASSETTE)) as tape:
        stage.say(f"$ p2os-emu --serve {CASSETTE}")
        with ZenohBus.open() as bus, gateway(tape.port, "--quiet", "--name", name):
            Stage(name, tape, bus, stage.folder, stage.say).see(keys.ODOM, what="odometry from the cassette")
    stage.say("a gateway on the cassette's port publishes what the recorded robot said")


def _check(stage: Stage) -> None:
    _recorded(stage)
    command = [sys.executable, "-m", "p2os_emu", "--check", str(stage.folder / CASSETTE)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    if done.returncode not in (0, 1):
        raise SceneFailed(done.stderr.strip())
    stage.say(f"$ p2os-emu --check {CASSETTE}")
    stage.say(done.stdout.strip())


def _mobilesim(stage: Stage) -> None:
    """The client's side in a few lines, as old programs do it: 36, 37, 38 and 35 ask for a laser."""
    model = configs.load(RobotModel, "robots", "p3dx-sh")
    frames = FrameDecoder()
    heard: Counter[str] = Counter()
    beams = 0
    with serial.serial_for_url(stage.robots.port, timeout=0.1) as line:
        for number in (Command.SYNC0, Command.SYNC1, Command.SYNC2, Command.OPEN):
            line.write(encode_command(number))
            time.sleep(0.05)
        line.write(encode_command(Command.GRIPPERVAL, -90) + encode_command(Command.GRIPREQUEST, 90))
        line.write(encode_command(Command.GYROCALCW, 100) + encode_command(Command.ADSEL, 2))
        line.write(encode_command(Command.SIM_STAT, 1))
        deadline = time.monotonic() + 3.0
        while time.monotonic() < deadline and not (beams and heard["SimulatorState"]):
            for found in frames.receive(line.read(4096), time.monotonic()):
                if isinstance(found, Frame):
                    packet = decode_packet(found.payload, model)
                    heard[type(packet).__name__] += not isinstance(packet, UnknownPacket)  # the handshake
                    beams = packet.total if isinstance(packet, ExtendedLaser) else beams
        line.write(encode_command(Command.CLOSE))
    if not beams:
        raise SceneFailed("no laser packet came")
    stage.say(f"a laser of {beams} beams in the robot's own line, and its true pose; heard: {dict(heard)}")


SCENES = (
    Scene(
        "wire",
        "what flows on a cable, in words",
        ("--robot", "p3dx-sh:{name}", "--record", "{folder}/" + CASSETTE),
        _wire,
    ),
    Scene(
        "cassette",
        "a recorded robot, played to a client",
        ("--robot", "p3dx-sh:{name}", "--record", "{folder}/" + CASSETTE),
        _cassette,
    ),
    Scene(
        "check",
        "a recording compared with what the emulator answers to the same commands",
        ("--robot", "p3dx-sh:{name}", "--world", "empty", "--record", "{folder}/" + CASSETTE),
        _check,
    ),
    Scene(
        "mobilesim",
        "its short options, its commands, and a laser in the robot's own line",
        ("-m", "office", "-r", "p3dx-sh:{name}", "-p", "0", "--as-simulator"),
        _mobilesim,
        has_gateway=False,
    ),
)

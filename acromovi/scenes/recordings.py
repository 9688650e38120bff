"""Scenes of the bytes on a cable: printed, recorded, replayed and compared; and of clients that need a simulator."""

import subprocess
import sys
import time
from collections import Counter

import configs
from acromovi.children import emulator, gateway
from acromovi.scenes.stage import Scene, SceneFailed, SceneStage
from bus import ZenohBus, keys
from gateway.serial_port import Port, open_port
from p2os import Command, ExtendedLaser, Frame, FrameDecoder, RobotModel, UnknownPacket, decode_packet, encode_command
from p2os.wire_log import WireLogEntry

RECORDING = "drive.jsonl"
RECORDED = "--robot p3dx-sh:{name} --record {folder}/" + RECORDING
SHOWN = 12
TURN_S = 0.05
HEARD_S = 1.0
LASER_REQUEST = (
    (Command.GRIPPERVAL, -90),
    (Command.GRIPREQUEST, 90),
    (Command.GYROCALCW, 100),
    (Command.ADSEL, 2),
    (Command.SIM_STAT, 1),
)
"""From -90 to 90 degrees, a degree a beam, with reflectance; and once the truth."""


def _wire(stage: SceneStage) -> None:
    entries = _recorded(stage)
    for entry in entries[:SHOWN]:
        stage.say(entry.as_text())
    stage.say(f"... and {len(entries) - SHOWN} more frames; acromovi wire FILE shows them all")


def _recorded(stage: SceneStage) -> list[WireLogEntry]:
    """A short drive, read back from its recording."""
    from acromovi.wire import replay

    stage.tell(keys.MOVE, distance=0.2)
    stage.wait(lambda: stage.truth()["x"] != 0.0 and abs(stage.truth()["linear"]) > 0.05, "a moving robot")
    entries: list[WireLogEntry] = []
    replay(stage.folder / RECORDING, None, lambda found: entries.extend(found))
    if len(entries) <= SHOWN:
        raise SceneFailed(f"only {len(entries)} frames were recorded")
    return entries


def _serve_recording(stage: SceneStage) -> None:
    _recorded(stage)
    name = f"{stage.robot}-tape"[-19:]
    with emulator("--quiet", "--serve", str(stage.folder / RECORDING)) as served:
        stage.say(f"$ p2os-emu --serve {RECORDING}")
        with ZenohBus.open() as bus, gateway(served.port, "--quiet", "--name", name):
            SceneStage(name, served, bus, stage.folder, stage.say).see(keys.ODOM, what="odometry from the cassette")
    stage.say("a gateway on the recording's port publishes what the recorded robot said")


def _check(stage: SceneStage) -> None:
    _recorded(stage)
    command = [sys.executable, "-m", "p2os_emu", "--check", str(stage.folder / RECORDING)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    if done.returncode not in (0, 1):
        raise SceneFailed(done.stderr.strip())
    stage.say(f"$ p2os-emu --check {RECORDING}")
    stage.say(done.stdout.strip())


def _mobilesim(stage: SceneStage) -> None:
    """The client's side in a few lines, as old programs have it: 36, 37, 38 and 35 ask for a laser."""
    port = open_port(stage.robots.port)
    try:
        for command in (Command.SYNC0, Command.SYNC1, Command.SYNC2, Command.OPEN):
            port.write(encode_command(command))
            time.sleep(TURN_S)
        for command, value in LASER_REQUEST:
            port.write(encode_command(command, value))
        heard, beams = _hear_laser(port)
        port.write(encode_command(Command.CLOSE))
    finally:
        port.close()
    if not beams:
        raise SceneFailed("no laser packet came")
    stage.say(f"a laser of {beams} beams in the robot's own line, and its true pose; heard: {dict(heard)}")


def _hear_laser(port: Port) -> tuple[Counter[str], int]:
    """Return the number of packets of each kind within a moment, and the beams of a sweep."""
    model = configs.load(RobotModel, "robots", "p3dx-sh")
    frames = FrameDecoder()
    heard: Counter[str] = Counter()
    beams = 0
    deadline = time.monotonic() + HEARD_S
    while time.monotonic() < deadline:
        time.sleep(TURN_S)
        for found in frames.receive(port.read(), time.monotonic()):
            if isinstance(found, Frame):
                packet = decode_packet(found.payload, model)
                heard[type(packet).__name__] += not isinstance(packet, UnknownPacket)  # the handshake
                beams = packet.total if isinstance(packet, ExtendedLaser) else beams
    return +heard, beams


SCENES = (
    Scene("wire", "what flows on a cable, in words", RECORDED, _wire),
    Scene(
        "cassette",
        "a recorded robot, played to a client",
        RECORDED,
        _serve_recording,
    ),
    Scene(
        "check",
        "a recording compared with what the emulator answers to the same commands",
        RECORDED + " --world empty",
        _check,
    ),
    Scene(
        "mobilesim",
        "its short options, its commands, and a laser in the robot's own line",
        "-m office -r p3dx-sh:{name} -p 0 --as-simulator",
        _mobilesim,
        has_gateway=False,
    ),
)

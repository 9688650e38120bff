"""`acromovi replay`: publish a recording on the bus again."""

import argparse
import sys
import time
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

from acromovi.keyboard import KeyReader
from acromovi.options import add_bus
from acromovi.subcommand import Subcommand
from acromovi.terminal import Terminal
from configs.extras import require

if TYPE_CHECKING:
    from bus.bus import Bus
    from recorder.playback import Playback, PlaybackPublisher
    from recorder.recording import McapRecording

TURN = 0.05  # s at most between two looks at the keys
JUMP = 10.0  # s that an arrow key moves
FASTER = 2.0  # times, of the keys + and -
MEETING_TIME = 1.0  # s in which the robots that live on the bus are seen
HELP = "space pauses · left and right jump 10 s · + and - change the speed · 0 begins again · q quits"
EPILOG = """\
examples:
  acromovi replay drive.mcap
  acromovi replay drive.mcap --speed 4 --start 60
  acromovi replay drive.mcap --rename happy=recorded --loop
  acromovi replay drive.mcap drive_1.mcap          the files of a recording that was split

In a terminal space pauses, the arrow keys jump 10 s back and forth, + and - change the speed, 0 begins again, q quits.
What told a robot or an agent to do something (cmd_vel, command, lease, acl and the like) is never published. A robot or
agent that lives on the bus keeps its name for itself: publish the recording under another one with --rename. With
--rename the frames of messages change as well, the contents of JSON do not.

Exit codes: 0 played to the end or ended by q, 1 no recording, or a name that lives on the bus (the reason is on
stderr), 2 wrong usage, 130 stopped by Ctrl-C.
"""


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "file", metavar="FILE", nargs="+", type=Path, help="recording; all of its files if it was split"
    )
    parser.add_argument("--speed", type=_speed, default=1.0, metavar="X", help="recorded seconds per second [1]")
    parser.add_argument("--start", type=_start, default=0.0, metavar="S", help="begin S seconds after its start [0 s]")
    parser.add_argument(
        "--rename", type=_renaming, action="append", default=[], metavar="OLD=NEW", help="rename a robot; repeatable"
    )
    parser.add_argument("--loop", action="store_true", help="begin again at the end, until Ctrl-C")
    parser.add_argument("--quiet", action="store_true", help="print errors only; read no keys")
    add_bus(parser)


def _speed(text: str) -> float:
    """A speed that a playback can have."""
    from recorder.channels import FASTEST, SLOWEST

    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not SLOWEST <= value <= FASTEST:
        raise argparse.ArgumentTypeError(f"{text} is no speed; choose one from {SLOWEST:g} to {FASTEST:g}")
    return value


def _start(text: str) -> float:
    """A time from the start of a recording, s."""
    try:
        value = float(text)
    except ValueError:
        value = -1.0
    if not 0 <= value < float("inf"):
        raise argparse.ArgumentTypeError(f"{text} is no time after the start in seconds")
    return value


def _renaming(text: str) -> tuple[str, str]:
    """Read `old=new`."""
    old, equals, new = text.partition("=")
    if not (old and equals and new):
        raise argparse.ArgumentTypeError(f"{text!r} is not OLD=NEW; write for example happy=recorded")
    return old, new


def _run(arguments: argparse.Namespace) -> int:
    """Play a recording to its end."""
    require("replaying", "recorder")
    from bus.session import ZenohBus
    from recorder.playback import Playback, PlaybackPublisher, platforms
    from recorder.recording import McapRecording

    renamed = dict(arguments.rename)
    with ExitStack() as stack:
        recording = stack.enter_context(McapRecording.open(arguments.file))
        notes = recording.notes
        for note in notes:
            print(f"acromovi replay: {note}", file=sys.stderr)
        unknown = sorted(renamed.keys() - {each.key.partition("/")[0] for each in recording.channels})
        if unknown:
            print(f"acromovi replay: --rename {unknown[0]}: the recording has no such name", file=sys.stderr)
            return 2
        bus = stack.enter_context(ZenohBus.open(arguments.bus))
        publisher = stack.enter_context(PlaybackPublisher(bus, renamed))
        names = NamesInUse(bus, platforms(recording, renamed))
        names.check_after(MEETING_TIME)
        playback = Playback(recording, arguments.speed, arguments.loop)
        if arguments.start:
            playback.seek(arguments.start, time.monotonic())
        if sys.stdin.isatty() and sys.stdout.isatty() and not arguments.quiet:
            with Terminal() as terminal:
                _play(playback, publisher, names, PlaybackKeys(terminal, recording).look)
        else:
            _play(playback, publisher, names, _wait)
        for note in set(recording.notes).difference(notes):  # found on the way
            print(f"acromovi replay: {note}", file=sys.stderr)
        if not arguments.quiet:
            print(_summary(publisher))
    return 0


class NamesInUse:
    """The names of a recording that robots and agents on the bus have."""

    def __init__(self, bus: "Bus", names: list[str]) -> None:
        """Watch the bus for tokens under these names."""
        self._seen: set[str] = set()
        self._bus = bus
        for name in names:
            bus.watch_alive(f"{name}/**", self._note)
        self._names = names

    def check_after(self, time_to_meet: float) -> None:
        """Wait until those that are there can have been seen.

        Raises:
            NameTaken: One of the names is in use.
        """
        until = time.monotonic() + time_to_meet
        while time.monotonic() < until:
            self.check()
            time.sleep(TURN)
        self.check()

    def check(self) -> None:
        """Raise NameTaken if one of the names is in use."""
        from bus.errors import NameTaken

        if self._seen:
            name = min(self._seen)
            raise NameTaken(
                f"{name} lives on this bus, so nothing recorded is published under its name; "
                f"choose another name: --rename {name}=recorded, or another --bus"
            )

    def _note(self, key: str, is_alive: bool) -> None:
        if is_alive:
            self._seen.add(key.partition("/")[0])


def _play(
    playback: "Playback",
    publisher: "PlaybackPublisher",
    names: NamesInUse,
    look: "Callable[[Playback, float], bool]",
) -> None:
    """Publish what is due until the end, or until `look` returns False."""
    playback.resume(time.monotonic())
    while not playback.ended:
        names.check()
        for recorded in playback.due(time.monotonic()):
            publisher.publish(recorded)
        at = playback.next_at()
        timeout = TURN if at is None else min(max(at - time.monotonic(), 0.0), TURN)
        if not look(playback, timeout):
            return


def _wait(playback: "Playback", timeout: float) -> bool:
    """Let time pass where no keys are read."""
    time.sleep(timeout)
    return True


class PlaybackKeys:
    """The keys of a playback in a terminal."""

    def __init__(self, terminal: Terminal, recording: "McapRecording") -> None:
        self._terminal = terminal
        self._recording = recording
        self._reader = KeyReader()

    def look(self, playback: "Playback", timeout: float) -> bool:
        """Obey the keys of the next seconds; return False to quit."""
        data = self._terminal.read(timeout)
        now = time.monotonic()
        if data is None or not all(self._press(key, playback, now) for key in self._reader.receive(data)):
            return False
        state = "paused" if playback.is_paused else f"speed {playback.speed:g}"
        names = ", ".join(map(str, self._recording.paths))
        self._terminal.show([f"{names}: {playback.elapsed:.0f} of {self._recording.duration:.0f} s, {state}", HELP])
        return True

    def _press(self, key: str, playback: "Playback", now: float) -> bool:
        from recorder.channels import FASTEST, SLOWEST

        match key:
            case "q":
                return False
            case " " if playback.is_paused:
                playback.resume(now)
            case " ":
                playback.pause(now)
            case "left":
                playback.seek(playback.elapsed - JUMP, now)
            case "right":
                playback.seek(playback.elapsed + JUMP, now)
            case "0":
                playback.seek(0.0, now)
            case "+":
                playback.set_speed(min(playback.speed * FASTER, FASTEST), now)
            case "-":
                playback.set_speed(max(playback.speed / FASTER, SLOWEST), now)
        return True


def _summary(publisher: "PlaybackPublisher") -> str:
    text = f"published {publisher.published} messages"
    if publisher.left_out:
        few = sorted(publisher.left_out)[:3]
        text += f"; nothing on {', '.join(few)}{' and others' if len(publisher.left_out) > 3 else ''}"
        text += ", where robots and agents are told what to do"
    return text


COMMAND = Subcommand(EPILOG, _add_arguments, _run)

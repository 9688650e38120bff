"""The `acromovi` command."""

import argparse
import os
import signal
import sys
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from types import FrameType

from acromovi.subcommand import add_subcommands
from configs.command_line import CommandParser

COMMANDS = {
    "echo": ("acromovi.echo", "Print what flows on a key"),
    "topics": ("acromovi.topics", "List the robots, and what flows now and how often"),
    "up": ("acromovi.up", "Bring a whole team up from one file, and end it with Ctrl-C"),
    "ps": ("acromovi.ps", "List the agents: where they live, and in which state"),
    "directory": ("acromovi.yellow_pages", "Find agents by service, robot or property"),
    "ask": ("acromovi.ask", "Ask an agent to do something"),
    "send": ("acromovi.send", "Send any ACL message to agents, and print the replies"),
    "agent": ("acromovi.agent", "Start, stop, suspend, resume, move or clone an agent"),
    "sniff": ("acromovi.sniff", "Listen to what agents say to each other, and draw it"),
    "leases": ("acromovi.leases", "List who holds which robot or element, and how that came"),
    "introspect": ("acromovi.introspect", "Look into a live agent: its mailbox, behaviours and conversations"),
    "container": ("acromovi.container", "Run a container: a robot's agents, a team's services, or an empty one"),
    "run": ("acromovi.run", "Run an application on the robots that are there"),
    "promote": ("acromovi.promote", "Make an application an agent, which others find and ask"),
    "new": ("acromovi.new", "Write an application to begin with"),
    "teleop": ("acromovi.teleop", "Drive a robot with the keys of this terminal"),
    "command": ("acromovi.command", "Tell a robot something: stop, move, gripper, ptz and more"),
    "record": ("acromovi.record", "Record robots and agents into an MCAP file"),
    "replay": ("acromovi.replay", "Publish a recording again, with pauses, jumps and speed"),
    "plot": ("acromovi.plot.command", "Draw a recording: paths, speeds, ranges, battery, latency"),
    "world": ("acromovi.world", "Look at and change the world of an emulator: truth, poses, doors, faults, time"),
    "wire": ("acromovi.wire", "Show what flows on a robot's cable, live or recorded"),
    "doctor": ("acromovi.doctor", "Say what is wrong with a port, a robot or this machine"),
    "try": ("acromovi.scenes.play", "See an accessory, a line or a fault at work, in a few seconds"),
    "console": ("acromovi.console", "See and drive a whole team in a browser"),
    "remote-vision": ("acromovi.remote_vision", "See through the cameras of a team in a browser, and turn them"),
    "camera": ("acromovi.camera", "Calibrate a camera by views of a chessboard"),
    "localize": ("acromovi.localize", "Find out where a robot is on a map, and follow it there"),
    "navigate": ("acromovi.navigation.command", "Let a robot find its way through rooms that it does not know"),
    "map": ("acromovi.mapping.command", "Build, save, join and draw maps of buildings"),
    "missions": ("acromovi.missions.command", "Play missions of the indoor navigation in lockstep, and judge them"),
    "demo": ("acromovi.demo", "Run an emulated robot, its gateway and a drive round the office, about a minute"),
    "keys": ("acromovi.keys", "Make the keys of a secure bus: who may look, who may drive"),
    "wrap": ("acromovi.wrap", "Make an agent of a program or a C library, as a file says"),
    "completion": ("acromovi.completion", "Print a script that lets a shell complete the words of acromovi"),
    "router": ("acromovi.router", "Run a Zenoh router, to join robots of several sites"),
}
DESCRIPTION = "Robots on the bus: look, drive, find out what is wrong."
EPILOG = """\
examples:
  acromovi topics                  which robots are there, and what do they say?
  acromovi echo happy/odom         print a robot's odometry
  acromovi teleop happy            drive it
  acromovi ps                      which agents are there?
  acromovi ask base@happy move distance=0.5
  acromovi COMMAND --help          more about one command

exit codes: 0 done, 1 failed (the reason is on stderr), 2 wrong usage, 130 stopped by Ctrl-C, 143 by SIGTERM
"""


class _Terminated(BaseException):
    """SIGTERM was received; unwinds the stack, so that terminals are restored and sessions closed."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command.

    Args:
        argv: The arguments; the program's own when None.
    Returns:
        The exit code.
    """
    given = list(sys.argv[1:] if argv is None else argv)
    parser = _parser()
    try:
        arguments, strange = parser.parse_known_args(given)
    except SystemExit:  # help or wrong usage; without this line the next one would load Zenoh
        raise
    except _user_errors() as err:  # an extra is missing, without which the command cannot be loaded
        print(f"acromovi: {err}", file=sys.stderr)
        return 1
    if strange:
        called = f"acromovi {arguments.command}"
        parser.exit(2, f"{called}: error: {parser.unrecognized(strange)}; {called} --help lists all\n")
    try:
        with _terminable():
            code = int(arguments.run(arguments))
        sys.stdout.flush()  # here, where a reader that has gone is no error
        return code
    except KeyboardInterrupt:
        _forget_coroutines()
        return 128 + signal.SIGINT
    except _Terminated:
        _forget_coroutines()
        return 128 + signal.SIGTERM
    except BrokenPipeError:  # the reader, `head` for example, has had enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except _user_errors() as err:
        print(f"acromovi {arguments.command}: {err}", file=sys.stderr)
        return 1


def _forget_coroutines() -> None:
    """Say nothing of a coroutine that a signal kept from being given to its loop."""
    # The program ends now, so it makes no difference that the coroutine does not run.
    warnings.filterwarnings("ignore", "coroutine .* was never awaited", RuntimeWarning)


def _parser() -> CommandParser:
    """Return the parser of all commands."""
    parser = CommandParser(
        prog="acromovi",
        description=DESCRIPTION,
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    parser.add_version()
    add_subcommands(parser, "command", COMMANDS)
    return parser


def _user_errors() -> tuple[type[Exception], ...]:
    """Return the errors that are reported in one sentence; imported late, since they load Zenoh."""
    from agents.platform.errors import AgentError
    from bus.errors import BusError
    from configs.loader import ConfigError
    from geometry import MapError

    return (AgentError, BusError, ConfigError, MapError)


@contextmanager
def _terminable() -> Iterator[None]:
    """Let SIGTERM unwind the stack as Ctrl-C does."""

    def terminate(number: int, frame: FrameType | None) -> None:
        raise _Terminated

    before = signal.signal(signal.SIGTERM, terminate)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


if __name__ == "__main__":
    sys.exit(main())

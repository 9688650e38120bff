"""`acromovi console`: see and drive a whole team in a browser."""

import argparse
import asyncio
import getpass
import json
import os
import sys
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

from acromovi.options import CONSOLE_PORT, add_apps, add_bus, tcp_port
from acromovi.subcommand import Subcommand

if TYPE_CHECKING:
    from bus.bus import Bus
    from recorder.recording import McapRecording

HOST = "127.0.0.1"
EPILOG = f"""\
examples:
  acromovi console
      then open http://{HOST}:{CONSOLE_PORT}/ in a browser, and end with Ctrl-C
  acromovi console --team acromovi
      with the walls of the team's world, and the robots where they began
  acromovi console --map floor.map
  acromovi console --replay drive.mcap --map floor.map
      show a recording like a live team, with play, pause and seek
  acromovi console --password
      write the password that is asked for when the console is served to other computers
  acromovi console --host 0.0.0.0
  acromovi console --host 0.0.0.0 --certificate keys/router.lab
      encrypted; a browser with the certificate of an operator may drive, one with that of a viewer may look, and one
      without is asked for the password, if there is one

The console needs no team to be running: robots are shown as they come and go. It can be opened on this computer only,
unless --host is given; then it asks for the password, or with --certificate for a certificate, which
`acromovi keys export` writes for a browser. A robot that is driven from a page stops when the key is released, and
when the page, its browser or the network is gone.

Exit codes: 1 the port is in use, or a file cannot be used (the reason is on stderr), 2 wrong usage, 130 stopped by
Ctrl-C, 143 by SIGTERM; robots that are driven from a page stop in every case.
"""


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--host", default=HOST, help="serve at this address of the computer [%(default)s]")
    parser.add_argument(
        "--port", type=tcp_port, default=CONSOLE_PORT, help="serve on this TCP port, 0 for any [%(default)s]"
    )
    parser.add_argument("--team", metavar="TEAM", help="team whose world and starts are shown: a name or a file")
    parser.add_argument("--map", metavar="FILE", type=Path, help="show these walls: an ARIA .map or a world file")
    parser.add_argument(
        "--replay",
        metavar="FILE",
        type=Path,
        nargs="+",
        help="show a recording in place of a live team; all of its files if it was split",
    )
    parser.add_argument("--control", metavar="PATH", default="", help="control socket of the emulator, for faults")
    parser.add_argument("--settings", metavar="FILE", type=Path, help="change settings of the application")
    parser.add_argument("--password", action="store_true", help="write the password file, and end")
    parser.add_argument(
        "--password-file", metavar="FILE", type=Path, default=password_file(), help="file of the password [%(default)s]"
    )
    parser.add_argument(
        "--certificate",
        metavar="FOLDER",
        type=Path,
        help="serve by TLS with this router's key, and let browsers in by their certificates",
    )
    parser.add_argument("--json", action="store_true", help='print one line of JSON once it serves: {"console": URL}')
    add_apps(parser)
    add_bus(parser)


def password_file() -> Path:
    """Return where the password of the console is kept, unless another file is given."""
    home = os.environ.get("XDG_CONFIG_HOME") or Path.home() / ".config"
    return Path(home) / "acromovi" / "console-password"


def _run(arguments: argparse.Namespace) -> int:
    """Serve the console until Ctrl-C."""
    from configs.extras import require

    require("acromovi console", "console")
    if arguments.replay and arguments.control:
        print("acromovi console: a recording has no emulator; leave out --control or --replay", file=sys.stderr)
        return 2
    if arguments.password:
        return _write_password(arguments.password_file)
    from apps.web.access import PasswordHash, Sessions
    from apps.web.certificates import PageCertificate
    from apps.web.origin import LOOPBACK

    certificate = PageCertificate.read(arguments.certificate) if arguments.certificate else None
    is_open = arguments.host not in LOOPBACK
    needs_password = arguments.password_file.exists() if certificate is not None else is_open
    password = PasswordHash.read(arguments.password_file) if needs_password else None
    from acromovi.floor_plan import floor_plan, floor_plan_of_team, starts_of_team
    from apps.console.program import ConsoleInputs
    from apps.console.server import serve
    from apps.console.settings import ConsoleSettings
    from apps.web.server import address, listening
    from bus.memory import MemoryBus
    from bus.session import ZenohBus

    settings = ConsoleSettings.load(arguments.settings)
    floor = floor_plan(arguments.map) if arguments.map else floor_plan_of_team(arguments.team)
    starts: Mapping[str, tuple[float, float, float]] = starts_of_team(arguments.team)
    inputs = ConsoleInputs(floor, starts, arguments.control, arguments.bus, str(Path.cwd()), arguments.apps)
    with ExitStack() as stack:
        listener = stack.enter_context(listening(arguments.host, arguments.port))
        recording = stack.enter_context(_recording(arguments.replay)) if arguments.replay else None
        bus: Bus = stack.enter_context(MemoryBus() if recording is not None else ZenohBus.open(arguments.bus))
        url = address(listener, arguments.host, "https" if certificate is not None else "http")
        words = json.dumps({"console": url}) if arguments.json else f"console: {url} (Ctrl-C ends it)"

        async def hold() -> None:
            access = settings.access
            sessions = Sessions(password, access.session_s, access.pause_s) if password is not None else None
            replay = None
            if recording is not None:
                from apps.console.replay import Replay  # of the extra `recorder`

                replay = stack.enter_context(Replay(recording, bus))
            await serve(
                bus,
                settings,
                inputs,
                sessions,
                listener,
                arguments.host,
                lambda: print(words, flush=True),
                replay,
                certificate,
            )

        asyncio.run(hold())
    return 0


def _recording(files: Sequence[Path]) -> "McapRecording":
    """Open the files of a recording, and report what of them cannot be read."""
    from configs.extras import require

    require("acromovi console --replay", "recorder")
    from recorder.recording import McapRecording

    recording = McapRecording.open(files)
    for note in recording.notes:
        print(f"acromovi console: {note}", file=sys.stderr)
    return recording


def _write_password(file: Path) -> int:
    """Ask for a password twice, or read it from a pipe, and write its hash."""
    from apps.web.access import PasswordHash

    if sys.stdin.isatty():
        password = getpass.getpass("password of the console: ")
        if getpass.getpass("the same again: ") != password:
            print("acromovi console: the two passwords differ; nothing was written", file=sys.stderr)
            return 1
    else:
        password = sys.stdin.readline().rstrip("\n")
    PasswordHash.of(password).write(file)
    print(f"password written to {file}; it is asked for when the console is served with --host")
    return 0


COMMAND = Subcommand(EPILOG, _add_arguments, _run)

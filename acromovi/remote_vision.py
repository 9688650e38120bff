"""`acromovi remote-vision`: see through a robot's camera in a browser, and turn its head."""

import argparse
import asyncio
from pathlib import Path

from acromovi.options import add_bus, tcp_port
from acromovi.subcommand import Subcommand

HOST, PORT = "127.0.0.1", 8080
EPILOG = f"""\
example:
  acromovi remote-vision happy
      then open http://{HOST}:{PORT}/ in a browser, and end with Ctrl-C

The page can be opened on this computer only, unless --host is given. Whoever can open it can turn the cameras of the
team. The head stops when the browser of the one who steers is closed, hidden or frozen.

Exit codes: 1 no such robot, no camera, or the port is in use (the reason is on stderr), 2 wrong usage, 130 stopped by
Ctrl-C, 143 by SIGTERM; the head stops in every case.
"""


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("robot", metavar="ROBOT", help="robot whose camera is shown first; the page lists the others")
    parser.add_argument("--host", default=HOST, help="serve at this address of the computer [%(default)s]")
    parser.add_argument("--port", type=tcp_port, default=PORT, help="serve on this TCP port, 0 for any [%(default)s]")
    parser.add_argument("--settings", metavar="FILE", type=Path, help="change settings of the application")
    add_bus(parser)


def _run(arguments: argparse.Namespace) -> int:
    """Serve the page until Ctrl-C."""
    from configs.extras import require

    require("acromovi remote-vision", "console", "vision")
    from agents.client.errors import RobotError
    from apps.remote_vision.page import serve
    from apps.remote_vision.settings import RemoteVisionSettings
    from apps.web.server import address, listening
    from bus.session import ZenohBus
    from configs.loader import ConfigError

    settings = RemoteVisionSettings.load(arguments.settings)
    with listening(arguments.host, arguments.port) as listener, ZenohBus.open(arguments.bus) as bus:
        words = f"remote vision of {arguments.robot}: {address(listener, arguments.host)} (Ctrl-C ends it)"
        try:
            asyncio.run(
                serve(bus, arguments.robot, settings, listener, arguments.host, lambda: print(words, flush=True))
            )
        except RobotError as err:
            raise ConfigError(str(err)) from err
    return 0


COMMAND = Subcommand(EPILOG, _add_arguments, _run)

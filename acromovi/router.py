"""`acromovi router`: run a Zenoh router, which connects the robots of several sites."""

import argparse
import json
import time

from acromovi.subcommand import Subcommand

EPILOG = """\
examples:
  acromovi router
      join programs of this machine that are started with --bus router
  acromovi router --listen tcp/[::]:7447
      the same for other machines; whoever reaches the port can drive the robots
  acromovi router --connect tcp/lab.example.org:7447
      join this site with another whose router listens there
  acromovi router --config secure-router:keys/router.lab --listen tls/[::]:7447
      let in only those who have a key, and each as far as its role goes (see acromovi keys --help)

With --json it prints one line once it routes: {"listen": [ENDPOINT, ...]}

It runs until stopped. Exit codes: 1 the address is taken or not understood (the reason is on stderr), 2 wrong usage,
130 stopped by Ctrl-C, 143 by SIGTERM.
"""

LOOK_PERIOD = 1.0
"""Seconds of one sleep: a signal that arrives just before one is noticed after it."""


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--listen",
        action="append",
        metavar="ENDPOINT",
        help="listen on this endpoint; repeatable [tcp/127.0.0.1:7447]",
    )
    parser.add_argument(
        "--connect",
        action="append",
        metavar="ENDPOINT",
        help="connect to another router, now or when it starts; repeatable",
    )
    parser.add_argument(
        "--config",
        metavar="PROFILE",
        default="site",
        help="site, secure-router[:FOLDER OF KEYS], or a file, TOML or Zenoh's JSON5 (default: %(default)s)",
    )

    parser.add_argument("--json", action="store_true", help="print one line of JSON once it routes")


def _run(arguments: argparse.Namespace) -> int:
    """Route until stopped."""
    from bus.session import ZenohBus, configuration

    given = {"listen/endpoints": arguments.listen, "connect/endpoints": arguments.connect}
    config = configuration(arguments.config, {key: value for key, value in given.items() if value})
    with ZenohBus(config):
        listen = _addresses(config.get_json("listen/endpoints"))
        for_people = f"routing on {', '.join(listen)}; stop with Ctrl-C"
        print(json.dumps({"listen": listen}) if arguments.json else for_people, flush=True)
        while True:
            time.sleep(LOOK_PERIOD)


def _addresses(endpoints_json: str) -> list[str]:
    """The endpoints; Zenoh allows one list, or one for each mode."""
    endpoints = json.loads(endpoints_json)
    if isinstance(endpoints, dict):
        endpoints = endpoints.get("router", [])
    return list(endpoints)


COMMAND = Subcommand(EPILOG, _add_arguments, _run)

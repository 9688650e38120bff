"""Options that several commands share."""

import argparse
import json
from pathlib import Path
from typing import Any

from configs.defaults import VARIABLE, default_bus

CONSOLE_PORT = 8090
"""TCP port of the web console."""


def add_bus(parser: argparse.ArgumentParser) -> None:
    """Add `--bus`."""
    parser.add_argument(
        "--bus",
        metavar="PROFILE",
        default=default_bus(),
        help="set the bus profile: local[:NAME] (this machine only), lan, router, secure[:FOLDER OF KEYS], or a file "
        f"[%(default)s; {VARIABLE} changes it]",
    )


def add_apps(parser: argparse.ArgumentParser) -> None:
    """Add `--apps`."""
    parser.add_argument(
        "--apps",
        metavar="DIR",
        action="append",
        type=_folder,
        default=[],
        help="add a folder of applications that can be started as agents: follow.py is the module follow; repeatable",
    )


def add_pairs(parser: argparse.ArgumentParser, option: str, pair: str, what: str) -> None:
    """Add an option that takes KEY=VALUE, any number of times."""
    what += "; a value is JSON, or text where it is not JSON; repeatable"
    parser.add_argument(option, metavar=pair, type=argument, action="append", default=[], help=what)


def _folder(text: str) -> Path:
    """A folder that is there."""
    path = Path(text).expanduser()
    if not path.is_dir():
        raise argparse.ArgumentTypeError(f"there is no folder {text}")
    return path


def argument(text: str) -> tuple[str, Any]:
    """Read `key=value`."""
    key, equals, value = text.partition("=")
    if not (key and equals):
        raise argparse.ArgumentTypeError(f"{text!r} is not KEY=VALUE; write for example on=true")
    try:
        return key, json.loads(value)
    except ValueError:
        return key, value


def seconds(text: str) -> float:
    """A positive number of seconds."""
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0 < value < float("inf"):
        raise argparse.ArgumentTypeError(f"{text} is not a positive number of seconds")
    return value


def count(text: str) -> int:
    """A positive whole number."""
    try:
        value = int(text)
    except ValueError:
        value = 0
    if value < 1:
        raise argparse.ArgumentTypeError(f"{text} is not a positive whole number")
    return value


def tcp_port(text: str) -> int:
    """A TCP port."""
    if not (text.isdecimal() and int(text) < 1 << 16):
        raise argparse.ArgumentTypeError(f"{text} is not a TCP port; give a number from 0 to 65535")
    return int(text)

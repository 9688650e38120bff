"""Options that several commands share."""

import argparse
from pathlib import Path

from configs.defaults import VARIABLE, default_bus


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


def _folder(text: str) -> Path:
    """A folder that is there."""
    path = Path(text).expanduser()
    if not path.is_dir():
        raise argparse.ArgumentTypeError(f"there is no folder {text}")
    return path


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

"""Options that several commands share."""

import argparse


def add_bus(parser: argparse.ArgumentParser) -> None:
    """Add `--bus`."""
    parser.add_argument(
        "--bus",
        metavar="PROFILE",
        default="local",
        help="how to reach the bus: local (this machine only), lan, router, secure[:FOLDER OF KEYS], or a file "
        "(default: %(default)s)",
    )


def seconds(text: str) -> float:
    """A positive number of seconds."""
    value = float(text)
    if not 0 < value < float("inf"):
        raise argparse.ArgumentTypeError(f"{text} is not a positive number of seconds")
    return value


def count(text: str) -> int:
    """A positive whole number."""
    value = int(text)
    if value < 1:
        raise argparse.ArgumentTypeError(f"{text} is not a positive number")
    return value

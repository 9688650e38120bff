"""Map files as arguments of commands."""

import argparse
from pathlib import Path

from acromovi.sniff import new_file

ENDINGS = (".map", ".yaml", ".yml")
PICTURES = (".png", ".svg")


def new_map(text: str) -> Path:
    """Return the path of a map file that can be written."""
    path = new_file(text)
    if path.suffix not in ENDINGS:
        raise argparse.ArgumentTypeError(f"{text} ends neither in .map (ARIA) nor in .yaml (ROS)")
    return path


def new_picture(text: str) -> Path:
    """Return the path of a picture that can be written."""
    path = new_file(text)
    if path.suffix not in PICTURES:
        raise argparse.ArgumentTypeError(f"{text} ends neither in .png nor in .svg")
    return path

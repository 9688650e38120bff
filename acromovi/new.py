"""`acromovi new`: write an example application."""

import argparse
import inspect
import keyword
import sys
from pathlib import Path

from acromovi.subcommand import Subcommand

EPILOG = """\
example:
  acromovi new patrol
      write patrol.py, which wanders about as it is; then: acromovi run patrol.py

Exit codes: 0 written, 1 there is such a file already, 2 wrong usage.
"""
TEMPLATE = "apps.wander"


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("name", metavar="NAME", type=_identifier, help="name of the application: letters, digits and _")


def _identifier(text: str) -> str:
    """A name that a file and an agent can have."""
    name = text.removesuffix(".py")
    if not name.isidentifier():
        raise argparse.ArgumentTypeError(f"{text!r} is no name for an application; use letters, digits and _")
    if keyword.iskeyword(name) or name in sys.stdlib_module_names:  # each program beside it would import it
        raise argparse.ArgumentTypeError(f"{text!r} is a word of Python's own; choose another name")
    return name


def _run(options: argparse.Namespace) -> int:
    """Write the file, unless it exists."""
    file = Path(f"{options.name}.py")
    try:
        with file.open("x", encoding="utf-8") as written:
            written.write(_application(options.name))
    except OSError as err:
        why = "there is such a file already; choose another name" if isinstance(err, FileExistsError) else err.strerror
        print(f"acromovi new: {file} cannot be written: {why}", file=sys.stderr)
        return 1
    print(f"wrote {file}; run it with: acromovi run {file}")
    return 0


def _application(name: str) -> str:
    """Return the source of a new application: the one shipped with Acromovi, renamed."""
    from apps import wander

    return (
        inspect.getsource(wander)
        .replace("APPLICATION", f"{name}.py")
        .replace("NAME@apps", f"{name}@apps")
        .replace('SERVICES = ("wander",)', f'SERVICES = ("{name}",)')
    )


COMMAND = Subcommand(EPILOG, _add_arguments, _run)

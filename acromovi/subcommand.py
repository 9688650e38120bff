"""Commands with subcommands, of which only the one that is asked for is imported."""

import argparse
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib import import_module
from typing import Any

from configs.command_line import CommandParser


@dataclass(frozen=True, slots=True)
class Subcommand:
    """A command in a module of its own, which names it `COMMAND`.

    epilog: the end of its help text, examples and exit codes. add_arguments: describes its command line. run: carries
    it out, and returns the exit code; None where subcommands of its own do.
    """

    epilog: str
    add_arguments: Callable[[argparse.ArgumentParser], None]
    run: Callable[[argparse.Namespace], int] | None = None


def add_subcommands(parser: argparse.ArgumentParser, dest: str, table: Mapping[str, tuple[str, str]]) -> None:
    """Add subcommands. The parsed arguments have the chosen name as `dest`, and its `Subcommand.run` as `run`.

    Args:
        parser: Of the command above.
        dest: Attribute for the name; its upper case stands for it in the help text.
        table: Name to module and summary. A module is imported when the words after its name are parsed.
    """
    commands = parser.add_subparsers(dest=dest, metavar=dest.upper(), required=True, parser_class=LazyParser)
    for name, (module, summary) in table.items():
        commands.add_parser(
            name,
            help=summary,
            description=f"{summary}.",
            formatter_class=argparse.RawDescriptionHelpFormatter,
            allow_abbrev=False,
            module=module,
        )


class LazyParser(CommandParser):
    """The parser of one subcommand; imports its module when it begins to parse."""

    def __init__(self, *, module: str = "", **given: Any) -> None:
        super().__init__(**given)
        self._module = module

    def load(self) -> None:
        """Add the arguments of the module, unless that was done."""
        if self._module:
            command: Subcommand = import_module(self._module).COMMAND
            self._module = ""
            self.epilog = command.epilog
            self.set_defaults(run=command.run)
            command.add_arguments(self)

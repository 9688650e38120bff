"""Command line parser of all programs: `--version`, suggestions, options anywhere."""

import argparse
from collections.abc import Iterator, Sequence
from typing import Any

from configs.suggestion import meant

DISTRIBUTION = "acromovi"


class CommandParser(argparse.ArgumentParser):
    """A parser that suggests similar words, and that accepts options between repeated positional arguments.

    `argparse` by itself ends a repetition such as `KEY=VALUE ...` at the first option, and then rejects the rest. The
    parsers of subcommands are of this class too.
    """

    _is_mixing = False

    def parse_known_args(  # type: ignore[override]  # the overloads of the base class say no more than this
        self, args: Sequence[str] | None = None, namespace: Any = None
    ) -> tuple[Any, list[str]]:
        """Parse as the base class does, which calls this again for options and positional arguments separately."""
        self.load()
        if self._is_mixing or not any(each.nargs == argparse.ZERO_OR_MORE for each in self._get_positional_actions()):
            return super().parse_known_args(args, namespace)
        self._is_mixing = True
        try:
            return self.parse_known_intermixed_args(args, namespace)
        finally:
            self._is_mixing = False

    def load(self) -> None:
        """Add the arguments that are not added before a program needs them, in classes below this one."""

    def parse_args(  # type: ignore[override]  # the overloads of the base class say no more than this
        self, args: Sequence[str] | None = None, namespace: Any = None
    ) -> Any:
        """Parse the whole command line; an unknown argument ends the program with a suggestion and exit code 2."""
        parsed, strange = self.parse_known_args(args, namespace)
        if strange:
            self.error(self.unrecognized(strange))
        return parsed

    def unrecognized(self, words: Sequence[str]) -> str:
        """The error for words that this parser did not recognize, with the option that is spelt most like one."""
        known = {option.lstrip("-"): option for option in self._options()}
        for word in words:
            name = word.partition("=")[0].lstrip("-") if word.startswith("--") else ""
            if near := meant(name, known):
                return f"unrecognized arguments: {' '.join(words)}; did you mean {known[near]}?"
        return f"unrecognized arguments: {' '.join(words)}"

    def add_version(self) -> None:
        """Add `--version`, which prints the program's name and the version of the distribution, and exits with 0."""
        self.add_argument("--version", action=_PrintVersion, nargs=0, help="print the version and exit")

    def _options(self) -> Iterator[str]:
        """The options of this parser and of its subcommands."""
        for action in self._actions:
            yield from (option for option in action.option_strings if option.startswith("--"))
            if isinstance(action, argparse._SubParsersAction):
                for command in action.choices.values():
                    yield from command._options()

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        """Add a suggestion to the error for a value that is none of the choices."""
        try:
            super()._check_value(action, value)
        except argparse.ArgumentError as err:
            near = meant(str(value), map(str, action.choices or ()))
            raise argparse.ArgumentError(
                action, f"{err.message}; did you mean {near}?" if near else err.message
            ) from err


class _PrintVersion(argparse.Action):
    """Reads the version only when it is asked for, since that takes longer than the rest of a command line."""

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: str | Sequence[Any] | None,
        option_string: str | None = None,
    ) -> None:
        from importlib.metadata import version  # it takes longer than a whole command line

        print(f"{parser.prog} {version(DISTRIBUTION)}")
        parser.exit()

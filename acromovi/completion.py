"""`acromovi completion`: a script with which a shell completes commands, options and their values."""

import argparse
import re
import shlex
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field

from acromovi.subcommand import LazyParser, Subcommand, add_subcommands
from configs.command_line import CommandParser
from configs.loader import ConfigError

PROGRAM = "acromovi"
EPILOG = """\
examples:
  acromovi completion bash > ~/.local/share/bash-completion/completions/acromovi
  acromovi completion zsh > ~/.zfunc/_acromovi        with fpath=(~/.zfunc $fpath) before compinit in ~/.zshrc
  acromovi completion fish > ~/.config/fish/completions/acromovi.fish

The script is made from the commands of this version; make it anew after an update. What no option or command takes is
completed as a file.

Exit codes: 0 printed, 2 wrong usage.
"""


@dataclass(slots=True)
class CompletionWords:
    """What can follow some words of a command line.

    path: the program, and the commands before. commands, options: words with a summary each. values: the choices of an
    option, by its name. choices: of the arguments.
    """

    path: str
    commands: dict[str, str] = field(default_factory=dict)
    options: dict[str, str] = field(default_factory=dict)
    values: dict[str, list[str]] = field(default_factory=dict)
    choices: list[str] = field(default_factory=list)


def words_of(parser: argparse.ArgumentParser, path: str = PROGRAM) -> Iterator[CompletionWords]:
    """Yield the words of a parser, then those of its commands."""
    if isinstance(parser, LazyParser):
        with suppress(ConfigError):  # an extra of its module is not installed: it is completed without its options
            parser.load()
    found = CompletionWords(path)
    below: list[tuple[str, argparse.ArgumentParser]] = []
    for action in parser._actions:  # argparse has no public way to them
        if isinstance(action, argparse._SubParsersAction):
            found.commands = {each.dest: _plain(each.help) for each in action._choices_actions}
            below = [(name, each) for name, each in action.choices.items() if name in found.commands]
        elif action.help is not argparse.SUPPRESS:
            choices = [str(each) for each in action.choices or ()]
            for name in action.option_strings:
                found.options[name] = _plain(action.help)
                if choices:
                    found.values[name] = choices
            if not action.option_strings:
                found.choices += choices
    yield found
    for name, each in below:
        yield from words_of(each, f"{path} {name}")


def _plain(text: str | None) -> str:
    """A summary on one line, without what means something to a shell."""
    without_default = re.sub(r"\s*\[[^\]]*\]", "", (text or "").partition("\n")[0])
    return re.sub(r"[^\w .,;()/+-]", "", without_default)


def bash_script(all_words: list[CompletionWords]) -> str:
    """Return the script for bash."""
    return f"""\
# Completion of {PROGRAM} for bash; made by: {PROGRAM} completion bash
_{PROGRAM}() {{
    local word path={PROGRAM} words="" i cur=${{COMP_WORDS[COMP_CWORD]}} prev=${{COMP_WORDS[COMP_CWORD-1]}}
    for ((i = 1; i < COMP_CWORD; i++)); do
        case "$path ${{COMP_WORDS[i]}}" in
        {_paths(all_words)}) path="$path ${{COMP_WORDS[i]}}" ;;
        esac
    done
    case "$path $prev" in
    {_values(all_words, 'words="{}"')}
    *)
        case "$path" in
        {_lines(all_words, 'words="{}"')}
        esac
        ;;
    esac
    COMPREPLY=($(compgen -W "$words" -- "$cur"))
}}
complete -o default -F _{PROGRAM} {PROGRAM}
"""


def zsh_script(all_words: list[CompletionWords]) -> str:
    """Return the script for zsh."""
    described = [
        f"        {shlex.quote(each.path)}) found=({' '.join(shlex.quote(_described(*row)) for row in _rows(each))}) ;;"
        for each in all_words
    ]
    return f"""\
#compdef {PROGRAM}
# Completion of {PROGRAM} for zsh; made by: {PROGRAM} completion zsh
_{PROGRAM}() {{
    local place={PROGRAM} word
    local -a found
    for word in ${{words[2,CURRENT-1]}}; do
        case "$place $word" in
        {_paths(all_words)}) place="$place $word" ;;
        esac
    done
    case "$place ${{words[CURRENT-1]}}" in
    {_values(all_words, "found=({})")}
    *)
        case "$place" in
{chr(10).join(described)}
        esac
        ;;
    esac
    (( $#found )) && _describe {PROGRAM} found
    _files
}}
if [ "$funcstack[1]" = _{PROGRAM} ]; then
    _{PROGRAM} "$@"
else
    compdef _{PROGRAM} {PROGRAM}
fi
"""


def fish_script(all_words: list[CompletionWords]) -> str:
    """Return the script for fish."""
    lines = [
        f"# Completion of {PROGRAM} for fish; made by: {PROGRAM} completion fish",
        f"function __{PROGRAM}_at",
        f"    set -l place {PROGRAM}",
        "    for word in (commandline -opc)[2..]",
        '        switch "$place $word"',
        f"            case {' '.join(shlex.quote(each.path) for each in all_words[1:])}",
        '                set place "$place $word"',
        "        end",
        "    end",
        '    test "$place" = "$argv[1]"',
        "end",
    ]
    for each in all_words:
        at = f"complete -c {PROGRAM} -n {shlex.quote(f'__{PROGRAM}_at {shlex.quote(each.path)}')}"
        lines += [f"{at} -f -a {name} -d {shlex.quote(what)}" for name, what in each.commands.items()]
        lines += [f"{at} -f -a {shlex.quote(' '.join(each.choices))}"] * bool(each.choices)
        for name, what in each.options.items():
            option = f"-l {name[2:]}" if name.startswith("--") else f"-s {name[1:]}"
            values = f" -x -a {shlex.quote(' '.join(each.values[name]))}" if name in each.values else ""
            lines.append(f"{at} {option}{values} -d {shlex.quote(what)}")
    return "\n".join(lines) + "\n"


def _rows(words: CompletionWords) -> list[tuple[str, str]]:
    return [*words.commands.items(), *((each, "") for each in words.choices), *words.options.items()]


def _described(name: str, what: str) -> str:
    return f"{name}:{what}" if what else name


def _paths(all_words: list[CompletionWords]) -> str:
    return " | ".join(f'"{each.path}"' for each in all_words[1:])


def _values(all_words: list[CompletionWords], setting: str) -> str:
    """The cases of options that have choices."""
    cases = [
        f'"{each.path} {name}") {setting.format(" ".join(choices))} ;;'
        for each in all_words
        for name, choices in each.values.items()
    ]
    return "\n    ".join(cases)


def _lines(all_words: list[CompletionWords], setting: str) -> str:
    """The cases of what can follow each command."""
    cases = [f'"{each.path}") {setting.format(" ".join(name for name, _ in _rows(each)))} ;;' for each in all_words]
    return "\n        ".join(cases)


SHELLS = {"bash": bash_script, "zsh": zsh_script, "fish": fish_script}


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("shell", choices=SHELLS, help="the shell")


def _run(arguments: argparse.Namespace) -> int:
    """Print the script."""
    from acromovi.__main__ import COMMANDS

    parser = CommandParser(prog=PROGRAM, allow_abbrev=False)
    parser.add_version()
    add_subcommands(parser, "command", COMMANDS)
    print(SHELLS[arguments.shell](list(words_of(parser))), end="")
    return 0


COMMAND = Subcommand(EPILOG, _add_arguments, _run)

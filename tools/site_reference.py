"""The pages of the documentation site that are made from the code: commands, keys, messages, settings."""

import argparse
import os
from collections.abc import Iterator, Mapping
from pathlib import Path

from acromovi.__main__ import COMMANDS
from acromovi.subcommand import LazyParser, add_subcommands
from bus.keys import TOPICS, Kind
from configs.command_line import CommandParser

ROOT = Path(__file__).resolve().parents[1]
SETTINGS = (
    ("Web console", "apps/console/settings.toml"),
    ("Remote vision", "apps/remote_vision/settings.toml"),
    ("Robot following", "apps/robot_following/settings.toml"),
    ("Formations", "apps/formation/settings.toml"),
    ("Optical flow", "apps/optical_flow/settings.toml"),
    ("Docking", "apps/docking/settings.toml"),
    ("Surveillance", "apps/surveillance/settings.toml"),
    ("Fetching an object", "apps/fetch/settings.toml"),
    ("Map building", "agents/components/mapping/settings.toml"),
    ("Localization", "maps/localization/settings.toml"),
    ("Components of the indoor navigation", "apps/indoor_navigation/wiring.toml"),
)
"""Files with all settings of a part, and that part."""
_KINDS = {
    Kind.STREAM: ("Streams", "A robot publishes:"),
    Kind.COMMAND: ("Commands without reply", "A robot listens:"),
    Kind.QUERY: ("Queries", "A robot replies, in JSON:"),
    Kind.TOKEN: ("Tokens", "Liveliness tokens, which disappear with their owner:"),
}
_COLUMNS = "100"  # of a help text


def reference_pages() -> Mapping[str, str]:
    """Return the pages in Markdown, by their paths in the site."""
    return {
        "reference/commands.md": commands_page(),
        "reference/keys.md": keys_page(),
        "reference/messages.md": messages_page(),
        "reference/settings.md": settings_page(),
    }


def commands_page() -> str:
    """Return the help texts of all commands of `acromovi`."""
    os.environ["COLUMNS"] = _COLUMNS
    parser = CommandParser(prog="acromovi", allow_abbrev=False)
    add_subcommands(parser, "command", COMMANDS)
    lines = ["# Commands of acromovi", "", "What each command prints with `--help`.", ""]
    for path, each in _commands(parser, "acromovi"):
        text = each.format_help().rstrip().replace(str(Path.home()), "~")
        lines += [f"## {path}", "", "```text", text, "```", ""]
    return "\n".join(lines)


def keys_page() -> str:
    """Return the table of keys on the bus."""
    lines = [
        "# Keys on the bus",
        "",
        "A key begins with the name of a robot: `happy/odom`. [The bus](../bus.md) has examples.",
        "",
    ]
    for kind, (title, words) in _KINDS.items():
        lines += [f"## {title}", "", words, "", "| key | type | rate | meaning |", "|---|---|---|---|"]
        for topic in TOPICS:
            if topic.kind is kind:
                cells = (
                    f"`ROBOT/{topic.suffix}`",
                    f"`{topic.type_name}`" if topic.type_name else "",
                    topic.rate,
                    _cell(topic.meaning),
                )
                lines.append(f"| {' | '.join(cells)} |")
        lines.append("")
    return "\n".join(lines)


def messages_page() -> str:
    """Return the definitions of our message types."""
    lines = [
        "# Messages",
        "",
        "Types of ROS 2 are used where there is one. These are the others, `acromovi_msgs/msg/NAME`.",
        "",
    ]
    for file in sorted((ROOT / "bus/msg").glob("*.msg")):
        lines += [f"## {file.stem}", "", "```text", file.read_text(encoding="utf-8").rstrip(), "```", ""]
    return "\n".join(lines)


def settings_page() -> str:
    """Return the files of settings."""
    lines = [
        "# Settings",
        "",
        "All settings of the parts that have a file of them. A file of your own needs only what it changes.",
        "",
    ]
    for title, path in SETTINGS:
        lines += [
            f"## {title}",
            "",
            f"`{path}`",
            "",
            "```toml",
            (ROOT / path).read_text(encoding="utf-8").rstrip(),
            "```",
            "",
        ]
    return "\n".join(lines)


def _commands(parser: argparse.ArgumentParser, path: str) -> Iterator[tuple[str, argparse.ArgumentParser]]:
    if isinstance(parser, LazyParser):
        parser.load()
    yield path, parser
    for action in parser._actions:  # argparse has no public way to them
        if isinstance(action, argparse._SubParsersAction):
            for name, below in action.choices.items():
                yield from _commands(below, f"{path} {name}")


def _cell(text: str) -> str:
    return text.replace("|", "\\|").replace("<", "&lt;")

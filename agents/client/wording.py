"""Translates a gateway's advice, a command in JSON, into the call of this API that does the same."""

import json
import re
from collections.abc import Mapping
from typing import Any

OF_BASE = ("enable", "estop", "stop", "move", "turn", "heading", "drive")
ADVICE = re.compile(r"\b(send|and then|or) (?:(\w+) )?(\{[^{}]*\})")
TOKEN = "a command needs its token"


def in_api_words(why: str, element: str) -> str:
    """Return a reason in the terms of this API.

    `the arm has no power; send arm {"do": "power", "on": true}` becomes `the arm has no power; call arm.power(True)`.

    Args:
        why: The reason by the gateway, or an agent.
        element: The element, where the reason does not name one.
    """
    translated = ADVICE.sub(lambda found: _advice(found, element), why)
    return translated.replace(TOKEN, f"wait, or take it over with {element}.lease(priority=...)")


def _advice(found: re.Match[str], element: str) -> str:
    verb, command, written = found.groups()
    try:
        given = json.loads(written)
    except ValueError:  # it is no command but other text in braces
        return found.group()
    if command is None and "do" not in given:
        return found.group()
    return f"{'call' if verb == 'send' else verb} {_call(command or element, given)}"


def _call(command: str, given: Mapping[str, Any]) -> str:
    """Return the call that does the same as a command with its arguments."""
    values = {name: value for name, value in given.items() if name != "do"}
    if "do" in given:
        method = f"{command}.{given['do']}"
    else:
        method = f"base.{command}" if command in OF_BASE else f"{command}.power" if "on" in given else command
    arguments = [repr(value) if name == "on" else f"{name}={value!r}" for name, value in values.items()]
    return f"{method}({', '.join(arguments)})"

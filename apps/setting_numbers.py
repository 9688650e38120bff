"""The numbers among the settings of an application, so that each can be checked."""

from collections.abc import Mapping
from dataclasses import fields
from typing import Any


def numbers_of(table: Any, prefix: str = "") -> list[tuple[str, str, float]]:
    """Return all numbers in a dataclass of settings and in those within it: prefix, name and value."""
    found: list[tuple[str, str, float]] = []
    for each in fields(table):
        value = getattr(table, each.name)
        if isinstance(value, bool):
            continue
        if isinstance(value, int | float):
            found.append((prefix, each.name, float(value)))
        elif isinstance(value, Mapping):
            found += [(f"{prefix}{each.name}.", name, float(number)) for name, number in value.items()]
        elif not isinstance(value, str):
            found += numbers_of(value, f"{prefix}{each.name}.")
    return found

"""Checks of settings that a dataclass alone does not make."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import fields
from typing import Any

from configs.loader import ConfigError


def check_numbers(settings: Any, source: str, *, zero: bool = False) -> None:
    """See that all numbers of a dataclass, and of those within it, are finite and more than 0.

    Args:
        settings: The dataclass.
        source: Its file, for the message.
        zero: 0 is right as well.
    Raises:
        ConfigError: A number is not; the message names `source` and the key.
    """
    for name, value in _numbers(settings):
        if not (math.isfinite(value) and (value > 0.0 or (zero and value == 0.0))):
            least = "0 or more" if zero else "more than 0"
            raise ConfigError(f"{source}: {name} must be {least}, not {value:g}")


def _numbers(table: Any, prefix: str = "") -> Iterator[tuple[str, float]]:
    for each in fields(table):
        value = getattr(table, each.name)
        if isinstance(value, bool):
            continue
        if isinstance(value, int | float):
            yield f"{prefix}{each.name}", float(value)
        elif isinstance(value, Mapping):
            yield from ((f"{prefix}{each.name}.{name}", float(number)) for name, number in value.items())
        elif not isinstance(value, str):
            yield from _numbers(value, f"{prefix}{each.name}.")

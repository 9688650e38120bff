"""Settings of an application: a shipped file that has all of them, and a file of the user with changes."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any, TypeVar

from configs.loader import ConfigError, build, laid_over, read

T = TypeVar("T")


def load_with_changes(
    kind: type[T],
    shipped: Path,
    file: str | Path | None,
    changes: Mapping[str, Any] | None = None,
    *,
    zero: bool = False,
) -> tuple[T, str]:
    """Return the shipped settings with changes laid over them, and the file to name in further complaints.

    Args:
        kind: The dataclass; its numbers must be more than 0.
        shipped: The file with all settings.
        file: One that has some; none if empty.
        changes: Tables that are laid over both.
        zero: Numbers may be 0 as well.
    Raises:
        ConfigError: A file cannot be read, or a setting is unknown or not valid.
    """
    table = read(shipped)
    if file:
        table = laid_over(table, read(file))
    source = str(file or shipped)
    settings = build(kind, laid_over(table, changes or {}), source)
    _check_numbers(settings, source, zero=zero)
    return settings, source


def _check_numbers(settings: Any, source: str, *, zero: bool = False) -> None:
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
        elif not isinstance(value, str | tuple):
            yield from _numbers(value, f"{prefix}{each.name}.")

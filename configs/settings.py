"""Settings of a part: a shipped file that has all of them, and a file of the user with changes."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any, ClassVar, Self

from configs.loader import ConfigError, build, laid_over, read


class ShippedSettings:
    """Base of a frozen dataclass with all settings of a part; the file `SHIPPED` has them with their meaning.

    Numbers must be more than 0, or 0 as well where `MAY_BE_ZERO`.
    """

    __slots__ = ()
    SHIPPED: ClassVar[Path]
    MAY_BE_ZERO: ClassVar[bool] = False

    @classmethod
    def load(cls, file: str | Path | None = None, changes: Mapping[str, Any] | None = None) -> Self:
        """Return the shipped settings with changes laid over them.

        Args:
            file: One that has some; none if empty.
            changes: Tables that are laid over both.
        Raises:
            ConfigError: A file cannot be read, or a setting is unknown or not valid.
        """
        table = read(cls.SHIPPED)
        if file:
            table = laid_over(table, read(file))
        source = str(file or cls.SHIPPED)
        settings = build(cls, laid_over(table, changes or {}), source)
        _check_numbers(settings, source, zero=cls.MAY_BE_ZERO)
        settings.check(source)
        return settings

    def check(self, source: str) -> None:
        """See that the settings fit together, beyond the values of each; source: their file, for the message.

        Raises:
            ConfigError: They do not.
        """


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

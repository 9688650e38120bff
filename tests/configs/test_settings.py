"""Settings of a part: the shipped file, a file with changes, and what is not valid."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from configs import ConfigError
from configs.settings import ShippedSettings


@pytest.fixture
def kind(tmp_path: Path) -> type[ShippedSettings]:
    file = tmp_path / "settings.toml"
    file.write_text("slow = 0.5\nfast = 1.0\n", encoding="utf-8")

    @dataclass(frozen=True, slots=True)
    class Speeds(ShippedSettings):
        SHIPPED = file

        slow: float
        fast: float

        def check(self, source: str) -> None:
            if self.slow >= self.fast:
                raise ConfigError(f"{source}: slow must be below fast")

    return Speeds


def test_changes_of_a_file_and_of_a_table_are_laid_over_what_is_shipped(kind: Any, tmp_path: Path) -> None:
    own = tmp_path / "own.toml"
    own.write_text("slow = 0.2\n", encoding="utf-8")
    assert kind.load() == kind(0.5, 1.0)
    assert kind.load(own, {"fast": 3}) == kind(0.2, 3.0)


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("slow = 0.0", "slow must be more than 0, not 0"),
        ("slow = nan", "slow must be a number, not nan"),
        ("slow = 2.0", "slow must be below fast"),
        ("slwo = 2.0", r"unknown key slwo; did you mean slow\?"),
        ('SHIPPED = "other.toml"', "unknown key SHIPPED"),
    ],
)
def test_what_is_not_valid_is_one_sentence_with_the_file(
    kind: type[ShippedSettings], tmp_path: Path, text: str, why: str
) -> None:
    own = tmp_path / "own.toml"
    own.write_text(text, encoding="utf-8")
    with pytest.raises(ConfigError, match=f"own.toml: {why}"):
        kind.load(own)

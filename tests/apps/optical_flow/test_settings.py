"""The settings file, and nonsense in it."""

from pathlib import Path

import pytest

from apps.optical_flow.settings import FlowSettings
from configs import ConfigError
from tests.shown import files


def test_the_file_of_the_page_is_read(tmp_path: Path) -> None:
    (changes,) = files("optical-flow", "toml")[1:]
    mine = tmp_path / "mine.toml"
    mine.write_text(changes)
    assert FlowSettings.load(mine).drive.speed_m_s == 0.15


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("[drive]\nspeed_m_s = -1", "drive.speed_m_s must be more than 0, not -1"),
        ("[drive]\nspeed_m_s = 5", "drive.speed_m_s must be at most 1, not 5"),
        ("[drive]\nslow_m_s = 0.3", "drive.slow_m_s must be at most 0.2, not 0.3"),
        ("[safety]\nsilent_s = nan", "safety.silent_s must be a number, not nan"),
        ("[safety]\nsilence_s = 1", "silence_s"),
        ("[memory]\ncell_m = 'small'", "cell_m"),
        ("period_s = 2", "period_s must be at most 0.5, not 2"),
    ],
)
def test_nonsense_is_refused_in_one_sentence(tmp_path: Path, text: str, told: str) -> None:
    mine = tmp_path / "mine.toml"
    mine.write_text(text)
    with pytest.raises(ConfigError) as refused:
        FlowSettings.load(mine)
    assert told in str(refused.value)
    assert "\n" not in str(refused.value)

"""Settings of fetching."""

from pathlib import Path

import pytest

from apps.fetch.settings import FetchSettings
from configs import ConfigError


def test_shipped_settings_are_complete_and_have_colours() -> None:
    assert FetchSettings.load().shades["red"] == (0xCC, 0x1F, 0x1F)


def test_settings_of_an_arm_take_the_changes_of_a_file(tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text("[robot]\ngrip_m = 0.5\n[drive]\nspeed_m_s = 0.2")
    usual, mine = FetchSettings.load_for_arm(), FetchSettings.load_for_arm(file)
    assert (mine.robot.grip_m, mine.drive.speed_m_s) == (0.5, 0.2)
    assert mine.arm == usual.arm
    assert mine.robot.opening_m == usual.robot.opening_m < FetchSettings.load().robot.opening_m
    file.write_text("[object]\nwidest_m = 0.08")
    with pytest.raises(ConfigError, match=r"object.widest_m must be at most 0.07, not 0.08"):
        FetchSettings.load_for_arm(file)


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ('[colours]\nred = "crimson"', "colours.red must be a colour such as #cc1f1f, not 'crimson'"),
        ("[object]\nwidest_m = 0.5", "object.widest_m must be at most 0.2, not 0.5"),
        ("[drive]\nspeed_m_s = 0", "drive.speed_m_s must be more than 0"),
        ("[grip]\nstandof_m = 1", "standof_m"),
    ],
)
def test_a_setting_that_makes_no_sense_is_refused_by_its_name(tmp_path: Path, text: str, why: str) -> None:
    file = tmp_path / "mine.toml"
    file.write_text(text)
    with pytest.raises(ConfigError) as refused:
        FetchSettings.load(file)
    assert why in str(refused.value)

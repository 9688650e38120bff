"""The settings file and the arguments, and nonsense in them."""

from pathlib import Path
from typing import Any, cast

import pytest

from agents import RobotError, Team
from apps.optical_flow.application import main
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


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        ({"seconds": -1.0}, "seconds must be 0 or more, not -1; 0 wanders for ever"),
        ({"seconds": float("nan")}, "seconds must be 0 or more, not nan; 0 wanders for ever"),
        ({"settings": "none.toml"}, "none.toml cannot be read: No such file or directory"),
        (
            {"picture": "none/at/all.svg"},
            "the picture none/at/all.svg cannot be written; name a file that ends in .svg",
        ),
        ({"film": "flow.avi"}, "the film flow.avi cannot be written; name a file that ends in .gif or .mp4"),
    ],
)
def test_arguments_that_make_no_sense_are_refused_before_a_robot_is_looked_for(
    arguments: dict[str, Any], told: str
) -> None:
    class NoTeam:
        """A team that must not be asked."""

    with pytest.raises(RobotError) as refused:
        main(cast(Team, NoTeam()), **arguments)
    assert str(refused.value).startswith(told)
    assert "\n" not in str(refused.value)

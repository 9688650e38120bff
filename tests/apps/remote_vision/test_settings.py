"""The settings of remote vision, and what is wrong with a file of one's own."""

from pathlib import Path

import pytest

from apps.remote_vision.settings import RemoteVisionSettings
from configs import ConfigError


def test_a_file_changes_what_it_names(tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text("[images]\nold_s = 1.5\n")
    settings = RemoteVisionSettings.load(file)
    assert settings.images.old_s == 1.5
    assert settings.control == RemoteVisionSettings.load().control


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("[images]\nold_s = -1.0\n", "images.old_s must be more than 0"),
        ("[control]\nsilent_s = 5.0\n", "the times must ascend"),
        ("[control]\nzoom_step = 0.5\n", "zoom_step must be more than 1"),
        ("[control]\nsilnt_s = 5.0\n", "silent_s"),
    ],
)
def test_what_is_wrong_is_told(tmp_path: Path, text: str, why: str) -> None:
    file = tmp_path / "mine.toml"
    file.write_text(text)
    with pytest.raises(ConfigError, match=why):
        RemoteVisionSettings.load(file)

"""Files with settings of robot following, that of its page among them."""

from pathlib import Path

import pytest

import configs
from apps.robot_following.settings import FollowingSettings
from tests.shown import files


def test_the_file_of_the_page_is_read(tmp_path: Path) -> None:
    (changes,) = files("following", "toml")
    file = tmp_path / "settings.toml"
    file.write_text(changes)
    settings = FollowingSettings.load(file)
    assert (settings.drive.gap, settings.camera.field_of_view) == (1.5, 1.047)


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"drive": {"speed": -0.1}}, "drive.speed must be 0 or more, not -0.1"),
        ({"drive": {"gap": 0.7}}, "drive.gap must be more than drive.nearest, 0.8 m, not 0.7"),
        ({"period": 0.0}, "period must be more than 0 s"),
    ],
)
def test_settings_that_make_no_sense_are_refused(changes: dict[str, object], told: str) -> None:
    with pytest.raises(configs.ConfigError, match=told):
        FollowingSettings.load(changes=changes)

"""The file on the page of robot following."""

from pathlib import Path

from apps.robot_following.settings import load_settings
from tests.shown import files


def test_the_file_of_the_page_is_read(tmp_path: Path) -> None:
    (changes,) = files("following", "toml")
    file = tmp_path / "settings.toml"
    file.write_text(changes)
    settings = load_settings(file)
    assert (settings.drive.gap, settings.camera.field_of_view) == (1.5, 1.047)

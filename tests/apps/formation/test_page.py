"""The files on the page of formations."""

from pathlib import Path

from apps.formation.settings import FormationSettings
from apps.formation.shapes import shape_offsets
from tests.shown import files


def test_files_of_the_page_are_read(tmp_path: Path) -> None:
    offsets, changes = files("formation", "toml")
    shape, settings = tmp_path / "mine.toml", tmp_path / "settings.toml"
    shape.write_text(offsets)
    settings.write_text(changes)
    assert shape_offsets(str(shape), 3, 1.0, 0.5) == ((-1.0, 0.5), (-1.0, -0.5), (-2.0, 0.0))
    changed = FormationSettings.load(settings)
    assert (changed.points.spacing_m, changed.members.when_stopped) == (1.2, "wait")
    assert changed.radius("max") == 0.5

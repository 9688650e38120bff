"""The pictures of the documentation can be made anew, and are small."""

from collections.abc import Callable
from pathlib import Path

import pytest
from PIL import Image

from tests.live_team import ROOT
from tools.make_pictures import drive, team, texture_lab

PICTURES = ROOT / "docs" / "pictures"
LARGEST = 150_000  # bytes


@pytest.mark.parametrize("make", [drive, team, texture_lab], ids=lambda make: str(make.__name__))
def test_a_picture_is_made_in_the_size_that_it_has_in_the_documentation(
    make: Callable[[Path], None], tmp_path: Path
) -> None:
    make(tmp_path)
    assert size(tmp_path / f"{make.__name__}.png") == size(PICTURES / f"{make.__name__}.png")


@pytest.mark.parametrize("picture", sorted(PICTURES.iterdir()), ids=lambda path: str(path.name))
def test_a_picture_is_small(picture: Path) -> None:
    assert picture.stat().st_size < LARGEST


def size(picture: Path) -> tuple[int, int]:
    """Return width and height in pixels."""
    with Image.open(picture) as image:
        return image.size

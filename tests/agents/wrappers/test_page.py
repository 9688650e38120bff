"""The page on wrappers: what it shows can be used as it stands."""

import asyncio
import re
import shutil
from pathlib import Path

from agents.wrappers.wrapped import Wrapped
from agents.wrappers.wrapper_file import WrapperFile
from tests.agents.wrappers.conftest import bench

PAGE = Path(__file__).resolve().parents[3] / "docs" / "wrappers.md"


def file_of_the_page(name: str, folder: Path) -> Path:
    """Write down a file that the page shows."""
    blocks = re.findall(r"```toml\n(.*?)```", PAGE.read_text(), re.DOTALL)
    path = folder / name
    path.write_text(next(block for block in blocks if block.startswith(f"# {name}")))
    return path


def test_the_counter_of_the_page_counts(tmp_path: Path) -> None:
    async def scenario() -> None:
        async with bench(file_of_the_page("counter.toml", tmp_path)) as at:
            assert (await at.ask("add", number=3)).value() == {"sum": 3}
            assert (await at.ask("add", number=4)).value() == {"sum": 7}

    asyncio.run(scenario())


def test_the_filters_of_the_page_filter(tmp_path: Path, filters: Path) -> None:
    shutil.copy(filters, tmp_path / "filters.so")

    async def scenario() -> None:
        async with bench(file_of_the_page("filters.toml", tmp_path)) as at:
            assert (await at.ask("threshold", image="AP8=", width=2, height=1)).value()["value"] == 1

    asyncio.run(scenario())


def test_the_files_of_the_page_are_read_without_complaint(tmp_path: Path) -> None:
    (tmp_path / "filters.so").touch()
    for name in ("counter.toml", "filters.toml"):
        Wrapped("it@happy", *WrapperFile.load(str(file_of_the_page(name, tmp_path))))

"""The source of the documentation site: every page is in the navigation, and every link leads to something."""

import re
from pathlib import Path

import pytest

from tools import site
from tools.site import LINK, TOP, assemble, moved

ENTRY = re.compile(r"^(?:.* <)?([\w./-]+?)>?$", re.MULTILINE)


@pytest.fixture(scope="module")
def source(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("site") / "source"
    assemble(folder)
    return folder


def test_every_page_is_in_the_navigation(source: Path) -> None:
    index = (source / "index.md").read_text(encoding="utf-8")
    navigation = set(ENTRY.findall(index[index.index("```{toctree}") :]))
    pages = {page.relative_to(source).with_suffix("").as_posix() for page in source.rglob("*.md")}
    assert {page for page in pages if not page.startswith(("api/", "repository/"))} - navigation == {"index"}
    assert {Path(name).stem for name in TOP} <= navigation
    assert "api/*" in (source / "api.md").read_text(encoding="utf-8")


def test_every_link_of_a_page_leads_to_a_page_or_a_file(source: Path) -> None:
    missing = [
        f"{page.relative_to(source)}: {found[1]}"
        for page in source.rglob("*.md")
        if "repository" not in page.parts
        for found in LINK.finditer(page.read_text(encoding="utf-8"))
        if not (page.parent / found[1]).is_file()
    ]
    assert missing == []
    assert (source / "repository/files/configs/teams/acromovi.toml").is_file()


def test_the_reference_is_made_from_the_code(source: Path) -> None:
    reference = {page.stem: page.read_text(encoding="utf-8") for page in (source / "reference").glob("*.md")}
    assert "## acromovi navigate go" in reference["commands"]
    assert str(Path.home()) not in reference["commands"]
    assert "`ROBOT/lease/state`" in reference["keys"]
    assert "## RobotState" in reference["messages"]
    assert "silent_s = 0.3" in reference["settings"]


def test_links_out_of_the_site_lead_to_copies_and_folders_are_not_linked() -> None:
    linked: set[str] = set()
    text = "[a](../PROTOCOL.md#x) [b](../configs/teams/acromovi.toml) [c](../examples) [d](bus.md) [e](https://x.org)"
    assert moved(text, "docs", "", linked) == (
        '[a](PROTOCOL.md#x) <a href="files/configs/teams/acromovi.toml">b</a> c [d](bus.md) [e](https://x.org)'
    )
    assert linked == {"configs/teams/acromovi.toml"}
    assert (site.ROOT / "README.md").is_file()

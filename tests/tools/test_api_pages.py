"""`docs/api.md` and `docs/api/` describe exactly what the packages export."""

import importlib
from pathlib import Path

import pytest

from tools.api_pages import INDEX, PAGES, PUBLIC, look_up, markdown, pages, write
from tools.structure import modules

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def texts() -> dict[Path, str]:
    return pages()


def test_the_pages_are_up_to_date_or_make_docs_writes_them(texts: dict[Path, str]) -> None:
    committed = [INDEX, *(path.relative_to(ROOT) for path in (ROOT / PAGES).glob("*.md"))]
    assert {path: (ROOT / path).read_text(encoding="utf-8") for path in committed} == texts


@pytest.mark.parametrize("package", PUBLIC)
def test_each_exported_name_has_a_heading(texts: dict[Path, str], package: str) -> None:
    headings = texts[PAGES / f"{package}.md"].splitlines()
    missing = [
        name for name in getattr(importlib.import_module(package), "__all__", []) if f"## {name}" not in headings
    ]
    assert missing == []


def test_each_exported_name_has_a_docstring() -> None:
    known = modules()
    entries = [look_up(known, known[package], name) for package in PUBLIC for name in known[package].exported()]
    undescribed = [entry.name for entry in entries if not entry.doc]
    assert undescribed == []


def test_a_name_that_is_defined_nowhere_is_an_error() -> None:
    known = modules()
    with pytest.raises(LookupError, match=r"bus\.Telegraph is defined nowhere"):
        look_up(known, known["bus"], "Telegraph")


def test_sections_of_a_docstring_become_lists() -> None:
    doc = "Drive.\n\nArgs:\n    speed: m/s,\n        forward.\nRaises:\n    ValueError: Too fast."
    assert markdown(doc) == (
        "Drive.\n\nArguments:\n\n- `speed`: m/s,\n  forward.\n\nRaises:\n\n- `ValueError`: Too fast."
    )


def test_a_page_of_a_package_that_is_no_longer_public_is_removed(texts: dict[Path, str], tmp_path: Path) -> None:
    (tmp_path / PAGES).mkdir(parents=True)
    (tmp_path / PAGES / "steam.md").touch()
    write(texts, tmp_path)
    assert {path.relative_to(tmp_path) for path in tmp_path.rglob("*.md")} == set(texts)

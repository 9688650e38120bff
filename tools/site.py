"""Build the documentation site: `python -m tools.site [FOLDER]`, by default `build/site`. Warnings are errors.

The source of the site is assembled first: the pages of `docs`, those at the top of the repository, those made from the
code (`site_reference.py`), and the files to which any of them links, so that the site can be read offline.
"""

import posixpath
import re
import shutil
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from tools.site_reference import reference_pages

ROOT = Path(__file__).resolve().parents[1]
TOP = ("GLOSSARY.md", "PROTOCOL.md", "CHANGELOG.md", "ARCHITECTURE.md", "CONTRIBUTING.md")
"""Pages from the top of the repository, which are at the top of the site as well."""
SITE = ROOT / "docs" / "site"
COPIES = "files"  # folder of the site for files of the repository
LINK = re.compile(r"(?<=\]\()(?!https?:|#|mailto:)([^)\s#]+)(#[^)\s]*)?(?=\))")
_COPY = re.compile(r"\[([^\]]+)\]\(path:([^)]+)\)")
_PACKAGES = "\n```{toctree}\n:hidden:\n:glob:\n\napi/*\n```\n"
_FOLDER = re.compile(r"\[([^\]]+)\]\(FOLDER\)")


def main(arguments: Sequence[str]) -> int:
    """Build the site; return the exit code."""
    from sphinx.cmd.build import build_main

    folder = Path(*arguments) if arguments else ROOT / "build" / "site"
    with tempfile.TemporaryDirectory() as scratch:
        source = Path(scratch) / "source"
        assemble(source)
        words = ["-b", "html", "-q", "-W", "--keep-going", "-d", f"{scratch}/state", str(source), str(folder)]
        code = build_main(words)
    if not code:
        print(f"open {folder / 'index.html'}")
    return code


def assemble(source: Path) -> None:
    """Write the source of the site into a folder that does not exist."""
    shutil.copytree(SITE, source)
    linked: set[str] = set()
    pages = {page.relative_to(ROOT / "docs").as_posix(): page for page in (ROOT / "docs").glob("*.md")}
    pages |= {page.relative_to(ROOT / "docs").as_posix(): page for page in (ROOT / "docs" / "api").glob("*.md")}
    pages |= {name: ROOT / name for name in TOP} | {"index.md": SITE / "index.md"}
    for path, page in pages.items():
        from_folder = page.parent.relative_to(ROOT).as_posix()
        text = moved(page.read_text(encoding="utf-8"), from_folder, posixpath.dirname(path), linked)
        if path == "api.md":
            text += _PACKAGES
        _write(source / path, text)
    for path, text in reference_pages().items():
        _write(source / path, text)
    shutil.copytree(ROOT / "docs" / "pictures", source / "pictures")
    extra = source / "repository" / COPIES
    for path in linked:
        (extra / path).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(ROOT / path, extra / path)


def moved(markdown: str, source: str, folder: str, linked: set[str]) -> str:
    """Return a page with its links as they are in the site.

    Args:
        markdown: The page.
        source: Folder of the repository from which its links count.
        folder: Its folder in the site.
        linked: The files of the repository outside of the site to which it links are added.
    """

    def link(found: re.Match[str]) -> str:
        path = posixpath.normpath(posixpath.join(source, found[1]))
        if path.startswith("docs/"):
            target = path.removeprefix("docs/")
        elif path in TOP:
            target = path
        elif path == "README.md":
            target = "index.md"
        elif (ROOT / path).is_file():
            linked.add(path)
            return "path:" + posixpath.relpath(f"{COPIES}/{path}", folder or ".")
        else:
            return "FOLDER"
        return posixpath.relpath(target, folder or ".") + (found[2] or "")

    text = LINK.sub(link, markdown)
    return _COPY.sub(r'<a href="\2">\1</a>', _FOLDER.sub(r"\1", text))


def _write(file: Path, text: str) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

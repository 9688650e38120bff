"""What is shown while `.venv` is made, and when it is made anew."""

import os
import re
from pathlib import Path

import pytest

from tools import make_venv
from tools.make_venv import INSTALLS, Progress, show

ROOT = Path(__file__).resolve().parents[2]
OUTPUT = """\
Obtaining file:///home/ann/acromovi
  Preparing editable metadata (pyproject.toml): finished with status 'done'
Collecting eclipse-zenoh>=1.9 (from acromovi==0.1.0)
  Downloading eclipse_zenoh-1.10.2-cp39-abi3-manylinux_2_17_x86_64.whl (10.3 MB)
Progress 0 of 10300000
Progress 5000000 of 10300000
Progress 10300000 of 10300000
Collecting pyserial>=3.5 (from acromovi==0.1.0)
  Downloading pyserial-3.5-py2.py3-none-any.whl (90 kB)
Collecting rosbags>=0.10.6 (from acromovi==0.1.0)
  Using cached rosbags-0.11.9-py3-none-any.whl
Installing collected packages: pyserial, rosbags, eclipse-zenoh, acromovi
Successfully installed acromovi-0.1.0 eclipse-zenoh-1.10.2 pyserial-3.5 rosbags-0.11.9
""".splitlines(keepends=True)


def test_without_a_terminal_each_large_package_and_step_has_a_line() -> None:
    assert "".join(show(iter(OUTPUT), 165, is_live=False)) == (
        "0 of about 165 MB: downloading eclipse-zenoh, 10 MB\n10 of about 165 MB: writing 4 packages\n"
    )


def test_in_a_terminal_one_line_grows_and_vanishes_in_the_end(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    shown = "".join(show(iter(OUTPUT), 165, is_live=True))
    lines = [line.removesuffix("\x1b[K") for line in shown.split("\r")]
    assert "5 of about 165 MB, 1 packages: downloading eclipse-zenoh" in lines
    assert lines[-2:] == ["10 of about 165 MB, 3 packages: writing 4 packages", ""]
    assert "\n" not in shown
    assert len(lines) == len(set(lines)) + 1  # none is drawn twice; it begins and ends with nothing


def test_a_line_is_not_wider_than_the_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "30")
    for line in "".join(show(iter(OUTPUT), 165, is_live=True)).split("\r"):
        assert len(line.removesuffix("\x1b[K")) < 30


def test_a_download_is_counted_once_its_size_is_known() -> None:
    progress = Progress()
    for line in OUTPUT[:6]:
        progress.read(line)
    assert (progress.done, progress.part) == (0.0, 5.0)
    for line in OUTPUT[6:]:
        progress.read(line)
    assert (progress.done, progress.part) == pytest.approx((10.39, 0.0))


@pytest.mark.parametrize("listed", ["pyproject.toml", "constraints.txt"])
def test_an_environment_is_current_until_a_list_of_packages_is_newer(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, listed: str
) -> None:
    monkeypatch.setattr(make_venv, "ROOT", tmp_path)
    for name in ("pyproject.toml", "constraints.txt"):
        (tmp_path / name).touch()
        os.utime(tmp_path / name, (100.0, 100.0))
    stamp = tmp_path / ".ready"
    assert not make_venv.is_current(stamp)
    stamp.touch()
    assert make_venv.is_current(stamp)
    later = stamp.stat().st_mtime + 1.0
    os.utime(tmp_path / listed, (later, later))
    assert not make_venv.is_current(stamp)


def test_an_environment_that_has_all_serves_the_demo_as_it_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("VENV", str(tmp_path))
    (tmp_path / ".ready").touch()
    assert make_venv.main(["demo"]) == 0
    assert {path.name for path in tmp_path.iterdir()} == {".demo", ".ready"}


def test_parts_of_packages_that_are_never_opened_are_removed(tmp_path: Path) -> None:
    packages = tmp_path / "lib" / "python3.12" / "site-packages"
    for name in ("pybullet_data", "pybullet_envs", "numpy/lib/tests", "numpy/testing"):
        (packages / name).mkdir(parents=True)
    make_venv.remove_unused(tmp_path)
    left = {path.relative_to(packages).as_posix() for path in packages.rglob("*")}
    assert left == {"numpy", "numpy/lib", "numpy/testing"}


def test_nothing_here_opens_what_is_removed() -> None:
    for source in ROOT.glob("*/**/*.py"):
        if ".venv" not in source.parts and source.parent.name != "tools":
            assert not re.search(rf"import ({'|'.join(make_venv.UNUSED)})\b", source.read_text(encoding="utf-8")), (
                source
            )


def test_the_readme_gives_the_sizes_that_are_shown() -> None:
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    for install in INSTALLS.values():
        assert f"{install.download} MB to download, {install.disk} MB on disk" in readme

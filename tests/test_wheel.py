"""The built wheel holds the packages of the design and nothing else, and works without the checkout."""

import os
import subprocess
import sys
import zipfile
from configparser import ConfigParser
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGES = {
    "acromovi",
    "agents",
    "apps",
    "bus",
    "cameras",
    "configs",
    "gateway",
    "geometry",
    "maps",
    "p2os",
    "p2os_emu",
    "recorder",
    "vision",
}


@pytest.fixture(scope="module")
def unpacked(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel, built from a copy of the checkout so that nothing is left behind there, and unpacked."""
    copy, built, unpacked = (tmp_path_factory.mktemp(name) for name in ("copy", "built", "unpacked"))
    files = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.split("\n")
    for name in filter(None, files):
        if (ROOT / name).exists():
            (copy / name).parent.mkdir(parents=True, exist_ok=True)
            (copy / name).write_bytes((ROOT / name).read_bytes())
    build = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", str(built), str(copy)]
    subprocess.run(build, capture_output=True, check=True)
    (wheel,) = built.glob("*.whl")
    zipfile.ZipFile(wheel).extractall(unpacked)
    return unpacked


def run(unpacked: Path, *arguments: str) -> str:
    """Run Python on the unpacked wheel from an empty folder, with an empty home."""
    empty = unpacked / "empty"
    empty.mkdir(exist_ok=True)
    environment = {**os.environ, "PYTHONPATH": str(unpacked), "HOME": str(empty)}
    command = [sys.executable, *arguments]
    return subprocess.run(command, cwd=empty, env=environment, capture_output=True, text=True, check=True).stdout


def test_wheel_holds_the_packages_of_the_design_and_nothing_else(unpacked: Path) -> None:
    found = {path.name for path in unpacked.iterdir() if path.suffix != ".dist-info" and path.name != "empty"}
    assert found == PACKAGES


def test_wheel_holds_every_source_and_data_file_of_its_packages(unpacked: Path) -> None:
    for package in PACKAGES:
        for source in (ROOT / package).rglob("*"):
            within = source.relative_to(ROOT)
            if source.is_file() and "__pycache__" not in within.parts:
                assert (unpacked / within).is_file(), f"{within} is not in the wheel"


def test_wheel_says_that_every_package_has_types(unpacked: Path) -> None:
    assert {path.parent.name for path in unpacked.glob("*/py.typed")} == PACKAGES


def test_wheel_names_the_three_commands_and_the_pytest_plugin(unpacked: Path) -> None:
    (path,) = unpacked.glob("*.dist-info/entry_points.txt")
    points = ConfigParser()
    points.read(path)
    assert set(points["console_scripts"]) == {"p2os-emu", "p2os-gateway", "acromovi"}
    assert dict(points["pytest11"]) == {"p2os_emu": "p2os_emu.pytest_plugin"}


def test_wheel_has_the_name_that_the_example_installs(unpacked: Path) -> None:
    (info,) = unpacked.glob("*.dist-info")
    named = f"/path/to/{info.name.removesuffix('.dist-info')}-py3-none-any.whl[emu]"
    assert named in (ROOT / "examples" / "foreign-driver" / "README.md").read_text()


def test_wheel_is_what_runs_when_it_is_installed(unpacked: Path) -> None:
    where = run(unpacked, "-c", "import p2os_emu, configs; print(p2os_emu.__file__); print(configs.__file__)")
    assert all(line.startswith(str(unpacked)) for line in where.split())


@pytest.mark.parametrize(
    ("option", "expected"), [("--list-robots", "powerbot-sh"), ("--list-worlds", "office"), ("--list-links", "rs232")]
)
def test_installed_emulator_finds_its_data_from_an_empty_folder(unpacked: Path, option: str, expected: str) -> None:
    assert expected in run(unpacked, "-m", "p2os_emu", option)


def test_installed_emulator_runs_from_an_empty_folder(unpacked: Path) -> None:
    assert '"model": "powerbot"' in run(
        unpacked, "-m", "p2os_emu", "--robot", "powerbot", "--json", "--duration", "0.1"
    )

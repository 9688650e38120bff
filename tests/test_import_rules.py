"""The picture of the rooms, kept true: who may import whom, and where a clock, a port or the bus may be touched."""

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

from tools.structure import statements

ROOT = Path(__file__).resolve().parents[1]

BELOW: dict[str, set[str]] = {
    "p2os": set(),
    "geometry": set(),
    "configs": set(),
    "cameras": {"configs"},
    "vision": {"configs"},
    "maps": {"geometry", "configs"},
    "bus": {"geometry", "configs"},
    "p2os_emu": {"p2os", "geometry", "configs"},
    "gateway": {"p2os", "bus", "cameras", "geometry", "configs"},
    "agents": {"bus", "cameras", "vision", "maps", "geometry", "configs"},
    "recorder": {"bus", "configs"},
    "apps": {"recorder", "agents", "bus", "vision", "maps", "geometry", "configs"},
    "acromovi": {
        "p2os",
        "geometry",
        "configs",
        "cameras",
        "vision",
        "maps",
        "bus",
        "p2os_emu",
        "gateway",
        "agents",
        "recorder",
        "apps",
    },
    "pty_tests": set(),  # it must not share a mistake with what it judges
}

CLOCKS_AND_PORTS = {
    "asyncio",
    "datetime",
    "fcntl",
    "multiprocessing",
    "os",
    "pty",
    "select",
    "selectors",
    "serial",
    "signal",
    "socket",
    "subprocess",
    "termios",
    "threading",
    "time",
    "tty",
}
BYTES_AND_TIME_COME_FROM_THE_CALLER = (
    "p2os",
    "vision",
    "maps",
    "p2os_emu/microcontroller",
    "p2os_emu/accessories",
    "gateway/driver.py",
    "gateway/elements",
)

ONLY_IN = {  # third party module: the places that may import it
    "zenoh": ("bus/", "acromovi/"),
    "pybullet": ("p2os_emu/world/",),
    "rosbags": ("bus/",),
    "serial": ("gateway/", "pty_tests/"),
}


def sources(place: str) -> list[Path]:
    """The Python files of a package, a folder or a file, relative to the root."""
    path = ROOT / place
    found = [path] if path.suffix == ".py" else sorted(path.rglob("*.py"))
    assert found, f"{place} holds no Python"
    return found


@cache  # each file is parsed once, and looked at by a dozen tests
def imported(path: Path) -> frozenset[str]:
    """Top names of all modules the file imports, functions included; its own package for a relative import."""
    return frozenset(_imports(path))


def _imports(path: Path) -> Iterator[str]:
    text = path.read_text(encoding="utf-8")
    tree = ast.parse(text)
    # Only where a module is imported by a call, expressions are looked through too.
    for node in ast.walk(tree) if "import_module" in text else statements(tree):
        match node:
            case ast.Import(names=names):
                yield from (alias.name.partition(".")[0] for alias in names)
            case ast.ImportFrom(module=str(module), level=0):
                yield module.partition(".")[0]
            case ast.ImportFrom(level=level) if level:
                yield path.relative_to(ROOT).parts[0]
            case ast.Call(func=ast.Attribute(attr="import_module"), args=[ast.Constant(value=str(module)), *_]):
                yield module.partition(".")[0]


def test_every_package_of_the_repository_is_in_the_picture() -> None:
    packages = {init.parent.name for init in ROOT.glob("*/__init__.py")}
    assert packages - {"benchmarks"} == set(BELOW)  # benchmarks may look at everything


@pytest.mark.parametrize("package", BELOW)
def test_package_imports_only_what_lies_below_it(package: str) -> None:
    for path in sources(package):
        above = imported(path) & BELOW.keys() - BELOW[package] - {package}
        assert not above, f"{path.relative_to(ROOT)} imports {above}"


def test_nothing_imports_what_ties_all_together() -> None:
    for package in BELOW.keys() - {"acromovi", "pty_tests"}:
        for path in sources(package):
            assert not imported(path) & {"acromovi", "benchmarks", "pty_tests", "tests"}, path.relative_to(ROOT)


@pytest.mark.parametrize("place", BYTES_AND_TIME_COME_FROM_THE_CALLER)
def test_neither_clock_nor_port_where_bytes_and_time_are_arguments(place: str) -> None:
    for path in sources(place):
        touched = imported(path) & CLOCKS_AND_PORTS
        assert not touched, f"{path.relative_to(ROOT)} imports {touched}"


@pytest.mark.parametrize("module", ONLY_IN)
def test_a_tool_of_the_trade_is_used_in_its_own_room_only(module: str) -> None:
    for package in BELOW:
        for path in sources(package):
            if module in imported(path):
                assert path.relative_to(ROOT).as_posix().startswith(ONLY_IN[module]), path.relative_to(ROOT)

"""Long tests come first, those that share something stay together, and quick ones can be run alone."""

import re
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import pytest

from tests import schedule
from tests.schedule import DRAWN, durations, longest_first, unit_of

ROOT = Path(__file__).resolve().parents[1]
NODEIDS = [
    "tests/bus/test_a.py::1",
    "tests/gateway/test_b.py::1",
    "tests/maps/test_c.py::1",
    "tests/vision/test_d.py::1",
    "tests/recorder/test_e.py::1",
]


@pytest.mark.parametrize(
    ("nodeid", "unit"),
    [
        ("tests/p2os/test_sip.py::test_a", "tests/p2os/test_sip.py"),
        ("tests/p2os/test_sip.py::TestB::test_c[1-p3dx-sh]", "tests/p2os/test_sip.py"),
        ("pty_tests/test_rows.py::test_a[amigo-TCM2]", "pty_tests on amigo"),
        ("pty_tests/test_rows.py::test_a[p3dx-sh]", "pty_tests on p3dx-sh"),
        ("pty_tests/test_bad_input.py::test_a[p3dx-sh-FA FB]", "pty_tests on p3dx-sh"),
        ("pty_tests/test_rows.py::test_a[p3dx-sh:gripper,arm-ARM_STATUS]", "pty_tests on p3dx-sh:gripper,arm"),
        ("pty_tests/test_foreign_driver.py::test_a[p3dx-sh@office]", "pty_tests on p3dx-sh@office"),
        ("pty_tests/test_client.py::test_no_robot", "pty_tests/test_client.py"),
        ("tests/apps/console/in_a_browser/test_agents.py::test_a", "tests/apps/console/in_a_browser/"),
        ("tests/apps/fetch/test_on_a_team.py::test_a", "emulated cameras"),
        ("tests/apps/optical_flow/test_on_a_team.py::test_a[9]", "emulated cameras"),
    ],
)
def test_a_unit_is_a_file_or_folder_or_a_robot_of_the_conformance_suite_or_all_with_emulated_cameras(
    nodeid: str, unit: str
) -> None:
    assert unit_of(nodeid) == unit


def test_the_longest_unit_comes_first_and_keeps_its_order() -> None:
    nodeids = ["a.py::1", "long.py::2", "a.py::3", "long.py::1", "longest.py::1"]
    seconds = {"long.py": 1.0, "longest.py": 3.0}
    assert longest_first(nodeids, seconds) == ["longest.py::1", "long.py::2", "long.py::1", "a.py::1", "a.py::3"]


class Worker:
    """A worker of pytest-xdist that runs nothing. given: what it was given to run."""

    shutting_down = False
    gateway = SimpleNamespace(id="none")

    def __init__(self) -> None:
        self.given: list[str] = []

    def send_runtest_some(self, numbers: list[int]) -> None:
        self.given += [NODEIDS[number] for number in numbers]

    def shutdown(self) -> None:
        self.shutting_down = True


def test_one_worker_takes_what_computes_and_the_others_when_that_is_done() -> None:
    options = SimpleNamespace(option=SimpleNamespace(), getvalue=lambda _: ["2*popen"])
    units = schedule.Units(cast(pytest.Config, options))
    computing, other = Worker(), Worker()
    for worker in (computing, other):
        units.add_node(worker)
        units.add_node_collection(worker, NODEIDS)
    units.schedule()
    assert computing.given == ["tests/maps/test_c.py::1", "tests/vision/test_d.py::1"]
    assert other.given == ["tests/bus/test_a.py::1", "tests/gateway/test_b.py::1"]
    units.mark_test_complete(computing, NODEIDS.index("tests/maps/test_c.py::1"))
    assert computing.given[2:] == ["tests/recorder/test_e.py::1"]


def test_a_run_changes_what_is_said_of_its_own_files_only(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    written = tmp_path / "durations.toml"
    written.write_text('# s per test\n"kept.py" = 7.0\n"quick_now.py" = 2.0\n"slow.py" = 1.0\n')
    monkeypatch.setattr(schedule, "DURATIONS", written)
    stopwatch = schedule.Stopwatch()
    for nodeid, seconds in (("slow.py::one", 2.0), ("slow.py::two", 4.0), ("quick_now.py::one", 0.1)):
        report = SimpleNamespace(nodeid=nodeid, duration=seconds)
        stopwatch.pytest_runtest_logreport(cast(pytest.TestReport, report))
    stopwatch.pytest_sessionfinish()
    assert written.read_text() == '# s per test\n"kept.py" = 7.0\n"slow.py" = 3.0\n'


def test_every_file_that_is_said_to_take_long_or_to_need_cameras_exists() -> None:
    assert [file for file in (*durations(), *DRAWN) if not (ROOT / file).is_file()] == []


def test_all_that_starts_a_team_takes_long() -> None:
    imports = re.compile(r"^from tests\.acromovi\.team\.running import", re.MULTILINE)
    starts = [path for path in (ROOT / "tests").rglob("test_*.py") if imports.search(path.read_text("utf-8"))]
    assert starts
    assert {str(path.relative_to(ROOT)) for path in starts} <= set(durations())

"""Which tests run, where and in which order.

With `--dist loadscope` a worker takes one unit after the other: the tests of a file, since they share what is started
for them, those of a folder that shares more, those of the conformance suite for one emulated robot, or those that need
emulated cameras. The longest units come first, so that the workers finish at the same time. One worker takes what
computes, so that two cores have room for the robots in real time of the others. With `--quick` the files that take long
are left out.
"""

import re
import tomllib
from collections import defaultdict
from pathlib import Path
from typing import Any

import pytest
from xdist.scheduler import LoadScopeScheduling

DURATIONS = Path(__file__).with_name("durations.toml")
QUICK = 0.02  # s that a test takes of a file that is not listed
WORTH_LISTING = 0.3  # s from which on a file is listed when the list is written anew
SHARED = re.compile(r"^tests/apps/console/in_a_browser/")  # one team and one browser for all files of the folder
# Programs that need the pictures of emulated cameras. A picture takes 10 ms of a core, and a busy emulator gives up
# pictures first, so that these programs wait for minutes where several draw at a time. They run one after the other.
DRAWN = frozenset(
    (
        "tests/acromovi/test_calibration_of_an_emulated_camera.py",
        "tests/agents/components/test_hands_and_eyes.py",
        "tests/apps/fetch/test_arm_on_a_team.py",
        "tests/apps/fetch/test_on_a_team.py",
        "tests/apps/formation/test_sight_on_a_team.py",
        "tests/apps/optical_flow/test_in_a_browser.py",
        "tests/apps/optical_flow/test_on_a_team.py",
        "tests/apps/remote_vision/test_in_a_browser.py",
        "tests/apps/robot_following/test_on_a_team.py",
    )
)
# Tests that compute all the time. Beside several of them robots in real time are late, and their tests take up to four
# times as long, with programs at work all that time. So one worker runs them, and then others.
COMPUTED = re.compile(
    r"^tests/(apps/indoor_navigation/|apps/surveillance/test_team|apps/\w+/test_lockstep|acromovi/missions/|maps/|vision/"
    r"|agents/components/test_(arm|base|accuracy)|p2os_emu/world/)"
)
SITE = re.compile(r"^(pty_tests)/.*\[([a-z0-9]+(?:-sh)?(?::[a-z0-9,:]+)?(?:@\w+)?)")


def durations() -> dict[str, float]:
    """s that a test takes on the average, by the files that take long."""
    return tomllib.loads(DURATIONS.read_text(encoding="utf-8"))


def unit_of(nodeid: str) -> str:
    """What one worker runs as a whole."""
    if shared := SHARED.match(nodeid):
        return shared[0]
    if file_of(nodeid) in DRAWN:
        return "emulated cameras"
    site = SITE.match(nodeid)
    return f"{site[1]} on {site[2]}" if site else file_of(nodeid)


def file_of(nodeid: str) -> str:
    """The file of a test."""
    return nodeid.partition("::")[0]


def longest_first(nodeids: list[str], seconds: dict[str, float]) -> list[str]:
    """Tests in units, those that take longest first; within a unit they keep their order."""
    units: dict[str, list[str]] = defaultdict(list)
    for nodeid in nodeids:
        units[unit_of(nodeid)].append(nodeid)
    ordered = sorted(units.values(), key=lambda unit: -sum(seconds.get(file_of(nodeid), QUICK) for nodeid in unit))
    return [nodeid for unit in ordered for nodeid in unit]


class Units(LoadScopeScheduling):  # type: ignore[misc]  # it has no types
    """Hands out units in the order in which the workers collect their tests."""

    def __init__(self, config: pytest.Config, log: Any = None) -> None:
        config.option.loadscopereorder = False  # else by the number of tests
        super().__init__(config, log)

    def _split_scope(self, nodeid: str) -> str:
        return unit_of(nodeid)

    def _assign_work_unit(self, node: Any) -> None:
        """Give a worker the next unit of its kind: what computes to the first worker, all else to the others."""
        computes = node is self.nodes[0]
        for unit in self.workqueue:
            if (COMPUTED.match(unit) is not None) == computes:
                self.workqueue.move_to_end(unit, last=False)
                break
        super()._assign_work_unit(node)


class Stopwatch:
    """Writes the list of durations anew."""

    def __init__(self) -> None:
        self._seconds: dict[str, float] = defaultdict(float)
        self._tests: dict[str, set[str]] = defaultdict(set)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Add up what the tests of a file take."""
        file = file_of(report.nodeid)
        self._seconds[file] += report.duration
        self._tests[file].add(report.nodeid)

    def pytest_sessionfinish(self) -> None:
        """Write it; what is said at its head stays, and what is said of files that were not run."""
        head = [line for line in DURATIONS.read_text(encoding="utf-8").splitlines() if line.startswith("#")]
        means = durations() | {file: seconds / len(self._tests[file]) for file, seconds in self._seconds.items()}
        rows = [f'"{file}" = {mean:.1f}' for file, mean in sorted(means.items()) if mean >= WORTH_LISTING]
        DURATIONS.write_text("\n".join([*head, *rows, ""]), encoding="utf-8")


def pytest_addoption(parser: pytest.Parser) -> None:
    """What may be given on the command line."""
    group = parser.getgroup("acromovi")
    group.addoption("--quick", action="store_true", help="leave out the files that take long")
    group.addoption("--write-durations", action="store_true", help="write tests/durations.toml anew from this run")


def pytest_configure(config: pytest.Config) -> None:
    """Take the time where that is wanted; not in the workers, whose reports come here."""
    if config.getoption("--write-durations") and not hasattr(config, "workerinput"):
        config.pluginmanager.register(Stopwatch())


@pytest.hookimpl(trylast=True)  # after pytest has put tests together that share a fixture
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave out what is not wanted, and in a worker put the rest in order."""
    seconds = durations()
    if config.getoption("--quick"):
        config.hook.pytest_deselected(items=[item for item in items if file_of(item.nodeid) in seconds])
        items[:] = [item for item in items if file_of(item.nodeid) not in seconds]
    if hasattr(config, "workerinput"):
        by_nodeid = {item.nodeid: item for item in items}
        items[:] = [by_nodeid[nodeid] for nodeid in longest_first(list(by_nodeid), seconds)]


@pytest.hookimpl(optionalhook=True)  # without pytest-xdist there is one process, and nothing to hand out
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Units | None:
    """Hand out units with `--dist loadscope`."""
    return Units(config, log) if config.getoption("dist") == "loadscope" else None

"""Emulated robots for tests: each test gets its own, on a fresh port, and it ends with the test.

    def test_driver_stops_when_someone_presses_stop(emulated_robot):
        with Driver(emulated_robot.port) as driver:
            driver.drive(0.3)
            emulated_robot.wait_until(lambda truth: truth.linear > 0.2)
            emulated_robot.fault("stop-pressed")
            emulated_robot.wait_until_it_stands()

Options come with a marker, or from the factory `emulate_robots`, which also makes several robots in one world:

    @pytest.mark.emulated_robot("powerbot", fit="laser", link="rs232")
    def test_driver_reads_the_laser(emulated_robot): ...

    def test_two_robots(emulate_robots):
        happy, grumpy = emulate_robots("p3dx:happy", "amigo:grumpy", world="office")

The plugin comes with the distribution: nothing needs to be imported or configured. Physics runs in a process of its
own, so that tests may run in parallel; it ends with the test, and also when the test's process is killed.
"""

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from typing import Any

import pytest

from p2os_emu.program import ChildFailed
from p2os_emu.robot_for_tests import RobotForTests, start

__all__ = ["emulate_robots", "emulated_robot"]

MARKER = "emulated_robot"
_USUAL = "p3dx"

EmulateRobots = Callable[..., tuple[RobotForTests, ...]]


def pytest_configure(config: pytest.Config) -> None:
    """Make the marker known."""
    config.addinivalue_line(
        "markers",
        f"{MARKER}(model='{_USUAL}', *, fit, world, link, faults, flash, seed, perfect): what the fixture of this name "
        "gives; see p2os_emu.start",
    )


@pytest.fixture
def emulate_robots() -> Iterator[EmulateRobots]:
    """Factory of emulated robots: `happy, grumpy = emulate_robots("p3dx:happy", "amigo:grumpy", world="office")`.

    Each call starts a world of its own; all of them end with the test. It takes models and options as
    `p2os_emu.start` does. A test whose robot cannot be had fails with the emulator's own sentence.
    """
    with ExitStack() as running:

        def emulate(*models: str, **options: Any) -> tuple[RobotForTests, ...]:
            __tracebackhide__ = True
            try:
                return running.enter_context(start(*(models or (_USUAL,)), **options))
            except ChildFailed as error:
                complaint = str(error)
            pytest.fail(complaint, pytrace=False)  # out here, where it does not drag the first error along

        yield emulate


@pytest.fixture
def emulated_robot(request: pytest.FixtureRequest, emulate_robots: EmulateRobots) -> RobotForTests:
    """An emulated robot of this test's own: `.port`, `.truth()`, `.fault("line-cut")`, `.place(x, y)`, `.wait_until()`.

    A P3-DX in an empty world, on a pseudo-terminal, unless a marker says otherwise:
    `@pytest.mark.emulated_robot("powerbot", fit="laser", world="office", link="rs232", faults=["line-cut@5+1"])`.
    """
    marker = request.node.get_closest_marker(MARKER)
    models, options = (marker.args, marker.kwargs) if marker else ((), {})
    if len(models) > 1:
        pytest.fail(f"{MARKER} is one robot, not {len(models)}; emulate_robots gives several", pytrace=False)
    return emulate_robots(*models, **options)[0]

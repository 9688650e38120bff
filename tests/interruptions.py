"""Motions in real time, which a busy machine may interrupt.

A robot stops when its gateway, its agents or its commander do not run for half a second, and whoever asked for the
motion is told so. A machine with more to do than it can keeps processes from running for that long now and then. What
is asked of the product is that it says so and works the next time; one that interrupts by itself does it each time.

A test that fails for this reason alone is therefore run again, fixtures of its own included, and listed at the end of
the run, with what was said. What fails for another reason fails at once.
"""

import re
from collections.abc import Callable
from functools import wraps
from typing import ParamSpec, TypeVar

import pytest

P = ParamSpec("P")
T = TypeVar("T")

TRIES = 3
INTERRUPTED = re.compile(
    r"(has been|was) silent for \d|connection to \S+ was lost|commander lost|lost after \d|is not connected|"
    r"(been|was) frozen|the machine is too busy|they are \d+\.\d s apart, and flow needs"
)
"""What is said of a motion that was interrupted, and of what an emulator gives up that cannot keep up.

The last is said of images for which a busy machine took too long."""


@pytest.hookimpl(tryfirst=True)  # before pytest-rerunfailures reads it
def pytest_configure(config: pytest.Config) -> None:
    """Run tests again that fail because they were interrupted, unless the command line says otherwise."""
    if config.option.reruns is None:
        config.option.reruns = TRIES - 1
        config.option.only_rerun = [INTERRUPTED.pattern]


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """List why tests were run again; a test that is interrupted on an idle machine has a defect."""
    if reports := terminalreporter.stats.get("rerun", []):
        terminalreporter.section("why tests were run again")
        for report in reports:
            terminalreporter.write_line(f"{report.nodeid}: {what_interrupted(report.longreprtext)}")


def what_interrupted(failure: str) -> str:
    """Return what was said of the interruption, from the text of a failure."""
    lines = (line.strip() for line in failure.splitlines())
    said = [line.removeprefix("E").strip() for line in lines if INTERRUPTED.search(line)]
    return said[-1] if said else "it is not said"


def again_if_interrupted(act: Callable[P, T]) -> Callable[P, T]:
    """Do a part of a test again, twice at most, if a motion was interrupted, where the whole test would take long.

    It must begin from anew each time.
    """

    @wraps(act)
    def acting(*arguments: P.args, **named: P.kwargs) -> T:
        for _ in range(TRIES - 1):
            try:
                return act(*arguments, **named)
            except Exception as error:
                if not INTERRUPTED.search(str(error)):
                    raise
        return act(*arguments, **named)

    return acting

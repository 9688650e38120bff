"""What the suite did not ask, and why: the last lines of its output."""

from collections import Counter
from collections.abc import Iterable

import pytest

from pty_tests.firmware import ROBOT_RUNS

FIRMWARE = "firmware"
"""Name of the property of a test that says which robot it asked, and what that runs."""


def lines(skipped: Iterable[pytest.TestReport], others: Iterable[pytest.TestReport]) -> list[str]:
    """Return the robots that were asked, and the tests that were not run by reason.

    Args:
        skipped: Reports of skipped tests of this suite.
        others: Reports of the other tests of this suite.
    """
    skipped, others = list(skipped), list(others)
    robots = {str(value) for report in (*skipped, *others) for key, value in report.user_properties if key == FIRMWARE}
    found = [f"robot: {robot}" for robot in sorted(robots)]
    by_reason: dict[str, Counter[str]] = {}
    for report in skipped:
        reason = report.longrepr[2] if isinstance(report.longrepr, tuple) else str(report.longrepr)
        test = report.nodeid.rpartition("::")[2].partition("[")[0]
        reason = reason.removeprefix("Skipped: ").partition(ROBOT_RUNS)[0]  # which is told above
        by_reason.setdefault(reason, Counter())[test] += 1
    for reason, tests in sorted(by_reason.items()):
        found.append(f"not asked, since {reason}:")
        found += [f"    {test}" + (f" ({count} times)" if count > 1 else "") for test, count in tests.items()]
    return found

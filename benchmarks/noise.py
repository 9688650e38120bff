"""How noisy the machine is while something is measured, and whether the figures can be trusted.

The unit of processor time is what a loop of ten million additions takes. A share of a core divided by the unit does not
depend on the machine.
"""

import os
import resource
import statistics
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from benchmarks.processes import TICKS_PER_SECOND, cpu_seconds

ADDITIONS = 10_000_000
UNITS = 3
"""How often the unit is measured at the begin and again at the end."""
SPREAD = 0.10
"""Of the unit, from which on figures are not trustworthy."""
OTHERS = 0.10
"""Share of the machine that other programs took, likewise."""
IDLE = (3, 4)  # the columns of /proc/stat that count no work: idle, and waiting for a disk
COLUMNS = 8  # those behind are contained in the first ones


@dataclass(frozen=True)
class Noise:
    """What was seen of the machine.

    unit: s of processor time that the loop takes, median. spread: between its fastest and its slowest run, as a share
    of the median. others: share of the whole machine that programs took that were not measured.
    """

    unit: float
    spread: float
    others: float

    @property
    def doubt(self) -> str:
        """Why figures of this time are not trustworthy; empty if they are."""
        reasons = []
        if self.spread > SPREAD:
            reasons.append(f"the processor's speed varied by {self.spread:.0%}")
        if self.others > OTHERS:
            reasons.append(f"other programs took {self.others:.0%} of the machine")
        return ", ".join(reasons)

    def __str__(self) -> str:
        return f"unit {self.unit:.3f} s, spread {self.spread:.0%}, others {self.others:.0%} of the machine"


class NoiseMeter:
    """Observes the machine from its construction until `read`."""

    def __init__(self, measured: Sequence[int] = ()) -> None:
        """Measure the unit, and count from now on.

        Args:
            measured: Process ids that belong to the measurement besides this process and its children.
        """
        self._measured = measured
        self._units = [unit() for _ in range(UNITS)]
        self._wall, self._busy, self._own = time.monotonic(), _busy_seconds(), self._own_seconds()

    def read(self) -> Noise:
        """Return what was seen since construction. Children count once they have ended."""
        wall = time.monotonic() - self._wall
        busy, own = _busy_seconds() - self._busy, self._own_seconds() - self._own
        self._units += [unit() for _ in range(UNITS)]
        median = statistics.median(self._units)
        others = max(busy - own, 0.0) / (wall * (os.cpu_count() or 1)) if wall else 0.0
        return Noise(median, (max(self._units) - min(self._units)) / median, min(others, 1.0))

    def _own_seconds(self) -> float:
        used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
        own = sum(each.ru_utime + each.ru_stime for each in used)
        return own + sum(cpu_seconds(pid) for pid in self._measured)


def unit() -> float:
    """Return the processor time that ten million additions take in a function, s."""
    begun = time.process_time()
    total = 0
    for number in range(ADDITIONS):
        total += number
    return time.process_time() - begun


def _busy_seconds() -> float:
    """Processor time that all processes have used since the machine was started, s."""
    first = Path("/proc/stat").read_text(encoding="ascii").splitlines()[0]
    ticks = [int(field) for field in first.split()[1 : 1 + COLUMNS]]
    return (sum(ticks) - sum(ticks[column] for column in IDLE)) / TICKS_PER_SECOND

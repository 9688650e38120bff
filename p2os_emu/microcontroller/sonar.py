"""The sonar scheduler: which disc fires when.

Discs are wired to four arrays of eight numbers. Every cycle one disc of each enabled array fires, all arrays at once,
in an order that POLLING changes. Source: fact sheet section 8.
"""

from collections.abc import Iterable

from p2os.arguments import LONGEST_SONAR_CYCLE, SHORTEST_SONAR_CYCLE
from p2os.robot_model import SONAR_ARRAY_SIZE, SONAR_ARRAYS, RobotModel
from p2os.sip import NO_ECHO
from p2os_emu.body import Body
from p2os_emu.microcontroller.flash import Flash
from p2os_emu.microcontroller.timers import TOLERANCE, Cadence

MAX_SEQUENCE = 16
"""Firings that one array's sequence holds."""


class SonarScheduler:
    """Fires the discs of one robot and keeps the newest reading of each until a SIP takes it.

    enabled: bit i is set while array i + 1 is enabled.
    """

    __slots__ = (
        "_active",
        "_cadence",
        "_fitted",
        "_next",
        "_numbers",
        "_readings",
        "_sequences",
        "_silenced",
        "enabled",
    )

    def __init__(self, model: RobotModel, flash: Flash) -> None:
        self._numbers = frozenset(disc.number for disc in model.sonar)
        self._fitted = _bits(number // SONAR_ARRAY_SIZE for number in self._numbers)
        self._cadence = Cadence(flash.sonar_cycle)
        self._readings: dict[int, float] = {}
        self._active: list[int] = []
        self.restore(flash)

    @property
    def cycle(self) -> float:
        """Time from one firing of an array to its next, s."""
        return self._cadence.period

    @cycle.setter
    def cycle(self, period: float) -> None:
        self._cadence.period = max(SHORTEST_SONAR_CYCLE, min(LONGEST_SONAR_CYCLE, period))

    def restore(self, flash: Flash) -> None:
        """Switch everything off and take the working parameters from FLASH: every array in rising order."""
        self.cycle = flash.sonar_cycle
        self._sequences: list[list[int]] = [[] for _ in range(SONAR_ARRAYS)]
        for number in sorted(self._numbers):
            self._sequences[number // SONAR_ARRAY_SIZE].append(number)
        self._next = [0] * SONAR_ARRAYS
        self._silenced = 0
        self._readings.clear()
        self.enabled = 0
        self._activate()

    def enable(self, on: bool, array: int | None = None) -> None:
        """Switch one array (0 to 3) or all of them."""
        affected = self._fitted & (_bits(range(SONAR_ARRAYS)) if array is None else 1 << array)
        self.enabled = self.enabled | affected if on else self.enabled & ~affected
        if on:
            self._silenced &= ~affected
        self._activate()

    def poll(self, sequence: bytes) -> None:
        """Change the firing order.

        Args:
            sequence: Numbers 1 to 32, others are ignored. Only the arrays of numbers that appear are changed. Without
                any byte all arrays fall silent, until they are enabled or appear in a sequence again.
        """
        if not sequence:
            self._silenced = self._fitted
        numbers = [byte - 1 for byte in sequence if byte - 1 in self._numbers]
        for array in {number // SONAR_ARRAY_SIZE for number in numbers}:
            self._sequences[array] = [n for n in numbers if n // SONAR_ARRAY_SIZE == array][:MAX_SEQUENCE]
            self._next[array] = 0
            self._silenced &= ~(1 << array)
        self._activate()

    @property
    def firing(self) -> int:
        """Bit i is set while array i + 1 fires."""
        return self.enabled & ~self._silenced

    def advance(self, body: Body, dt: float) -> None:
        """Let time pass; fire what falls due, all of it at once."""
        if self._active:
            cadence = self._cadence
            cadence.left -= dt
            if cadence.left <= TOLERANCE:
                self._fire(body, cadence.renew())

    def take(self) -> tuple[tuple[int, float], ...]:
        """The readings since the last call, oldest first: (number, range in m)."""
        readings = tuple(self._readings.items())
        self._readings.clear()
        return readings

    def _fire(self, body: Body, times: int) -> None:
        discs: dict[int, None] = {}  # a disc that falls due twice in a step would hear the same echo twice
        for _ in range(times):
            for array in self._active:
                sequence = self._sequences[array]
                place = self._next[array]
                discs[sequence[place]] = None
                self._next[array] = (place + 1) % len(sequence)
        fired = list(discs)
        for disc, distance in zip(fired, body.ping(fired), strict=True):
            self._readings.pop(disc, None)
            self._readings[disc] = min(distance, NO_ECHO)

    def _activate(self) -> None:
        """Work out which arrays fire; the first firing comes a full cycle after the silence ends."""
        active = [array for array in range(SONAR_ARRAYS) if self.firing >> array & 1 and self._sequences[array]]
        if not self._active:
            self._cadence.restart()
        self._active = active


def _bits(numbers: Iterable[int]) -> int:
    return sum(1 << number for number in set(numbers))

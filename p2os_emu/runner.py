"""The loop that moves an emulator in step with a clock.

Steps in which nothing is sent need not be taken on time: they are taken together, right before the next step in which
something may be sent, or when something has been received. A process that wakes up for each step finds its caches cold,
which costs three times as much as the step itself.
"""

import math
from collections.abc import Callable
from typing import Protocol

from p2os_emu.degradation import Degradation
from p2os_emu.emulator import STEP
from p2os_emu.links.poller import Poller
from p2os_emu.pacing import Pacer

_LONGEST_WAIT = 0.1  # s; ports and requests are heard so often at any speed
_TOGETHER = 0.004  # s of computing that steps may take together; commands that come meanwhile wait
_EARLY = 0.0003  # s before it is due from which on a step is taken, rather than to sleep once more
_ROUNDING = 1e-6  # of a step; times of silence are sums of steps
_LAST_STEP = STEP / 2  # s; emulated time is a sum of steps, an end is met within half of one


class _Stepped(Protocol):
    """An object that a runner steps: an emulator."""

    @property
    def time(self) -> float:
        """Emulated time since the start, s."""

    @property
    def silence(self) -> float:
        """Time in which nothing is sent unless something is received, s of emulated time; may be inf."""

    def step(self) -> None:
        """Move on by `STEP`."""


class Runner:
    """Steps an emulator in real time, polls its ports before every step, and calls a function between steps.

    between_steps: all called after the ports were heard, also while paused; at least ten times a second.
    needs_each_step: while one of them returns true, every step is taken on time.
    when_degraded: all called with the new level of `degradation`, whenever it has changed.
    degradation: what is given up because the machine is too busy; nothing where a speed above 1 was asked for, since
        then being late is no sign of load.
    is_paused: emulated time stands still; ports are still heard, what comes waits.
    """

    def __init__(
        self,
        emulator: _Stepped,
        poller: Poller,
        *,
        clock: Callable[[], float],
        sleep: Callable[[float], None],
        speed: float = 1.0,
    ) -> None:
        """Prepare; time counts from `run`.

        Args:
            emulator: What to move.
            poller: Of its ports.
            clock: Steady time, s.
            sleep: Waits for so many s of that clock.
            speed: Emulated seconds per second of the clock.
        """
        self.between_steps: list[Callable[[], None]] = []
        self.needs_each_step: list[Callable[[], bool]] = []
        self.when_degraded: list[Callable[[int], None]] = []
        self.degradation = Degradation()
        self.is_paused = False
        self._emulator = emulator
        self._poller = poller
        self._clock = clock
        self._sleep = sleep
        self._pacer = Pacer(STEP, clock(), speed)
        self._silent_cost = 0.0  # s of a step that sends nothing
        self._is_leaving = False

    @property
    def late_dropped(self) -> int:
        """Steps given up because they were more than a second late."""
        return self._pacer.dropped

    @property
    def lost(self) -> float:
        """Emulated time lost by dropped steps, s."""
        return self._pacer.dropped * STEP

    @property
    def speed(self) -> float:
        """Emulated seconds per second of the clock."""
        return self._pacer.speed

    @speed.setter
    def speed(self, speed: float) -> None:
        self._pacer.set_speed(speed, self._clock())

    def pause(self, on: bool) -> None:
        """Pause or resume emulated time."""
        self.is_paused = on
        self._pacer.restart(self._clock())

    def leave(self) -> None:
        """End `run` before the next step."""
        self._is_leaving = True

    def step(self, count: int) -> None:
        """Take some steps at once, as fast as they go."""
        for _ in range(count):
            self._poller.poll()
            self._emulator.step()

    def run(self, duration: float | None = None) -> None:
        """Run until `leave`, or until so many s of emulated time have passed."""
        end = None if duration is None else self._emulator.time + duration - _LAST_STEP
        self._pacer.restart(self._clock())
        while not self._is_leaving and (end is None or self._emulator.time < end):
            self._pass_silence(end)
            is_due = self._wait()
            self._poller.poll()
            for turn in self.between_steps:
                turn()
            if is_due and not (self.is_paused or self._is_leaving):
                self._begin_step()
                self._take_step()

    def report(self) -> str | None:
        """Return a sentence about load for people, at most one a minute."""
        return self.degradation.report(self.lost, self._clock())

    def _begin_step(self) -> None:
        now = self._clock()
        late = self._pacer.begin(now)
        has_changed = self.degradation.note(late, now) if self.speed <= 1.0 else self.degradation.reset()
        if has_changed:
            for tell in self.when_degraded:
                tell(self.degradation.level)

    def _take_step(self) -> None:
        began = self._clock()
        self._emulator.step()
        # One that sends costs more than a silent one. Were silent ones too costly to be taken together, it shows when
        # they no longer are.
        self._silent_cost = min(self._silent_cost, self._clock() - began)

    def _pass_silence(self, end: float | None) -> None:
        """Take the steps in which nothing is sent together: right before the next step, or when something has come."""
        steps = self._silent_steps(math.inf if end is None else end)
        if not steps:
            return
        last = self._pacer.deadline + (steps - 1) * STEP
        wait = last + max(0.0, STEP - steps * self._silent_cost - _EARLY) - self._clock()
        if wait > 0:
            self._poller.wait(min(wait, _LONGEST_WAIT))
        began = now = self._clock()
        taken = 0
        while taken < steps and now >= self._pacer.deadline:
            self._pacer.begin(now)
            self._emulator.step()
            taken += 1
            now = self._clock()
        if taken:
            self._silent_cost = (now - began) / taken

    def _silent_steps(self, end: float) -> int:
        """How many of the next steps may be taken together; the one that passes `end` (emulated time, s) is not."""
        # At another speed, steps either follow each other at once or take longer than ports may go unheard.
        if self.is_paused or self.speed != 1.0 or any(needs() for needs in self.needs_each_step):
            return 0
        most = _TOGETHER / self._silent_cost * STEP if self._silent_cost > 0.0 else math.inf
        silence = min(self._emulator.silence, most, _LONGEST_WAIT, end - self._emulator.time)
        return max(0, math.ceil(silence / STEP - _ROUNDING) - 1)

    def _wait(self) -> bool:
        """Wait for the next step, but not for long; return whether it is due."""
        wait = STEP if self.is_paused else self._pacer.deadline - self._clock()
        if wait > _EARLY:
            self._sleep(min(wait, _LONGEST_WAIT))
        return wait <= _LONGEST_WAIT

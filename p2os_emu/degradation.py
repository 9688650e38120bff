"""Load reduction: what an emulator gives up on a busy machine, so that robots keep real time. It reads no clock.

Stages come one after the other with growing lateness, and go one after the other once the emulator has kept up for a
while. Whether they come is a matter of wall time and so never the same twice; without load nothing here has an effect.
"""

STAGES = ("camera images", "people")
"""In the order in which they are given up: pictures, and the steps of people."""
LATE = (0.1, 0.2)
"""s of wall time that a step is late when each stage begins; steps later than `pacing.CATCH_UP_LIMIT` are lost."""
ON_TIME = 0.05
"""s; a step that is late by less is on time."""
RECOVERY = 2.0
"""s of wall time without a late step after which the last stage ends."""
REPORT_PERIOD = 60.0
"""s between two reports, at least."""


class Degradation:
    """Level of load reduction of an emulator.

    level: how many of `STAGES` are given up.
    """

    def __init__(self) -> None:
        self.level = 0
        self._late_at = 0.0
        self._worst = 0
        self._reported_at: float | None = None
        self._reported_lost = 0.0

    @property
    def given_up(self) -> tuple[str, ...]:
        """The stages that are given up now."""
        return STAGES[: self.level]

    def note(self, late: float, now: float) -> bool:
        """Take note of a step.

        Args:
            late: How late it begins, s of wall time.
            now: Wall time on a steady clock, s.
        Returns:
            Whether the level has changed.
        """
        before = self.level
        self.level = max(self.level, sum(late > each for each in LATE))
        self._worst = max(self._worst, self.level)
        if late >= ON_TIME:
            self._late_at = now
        elif self.level and now - self._late_at >= RECOVERY:
            self.level -= 1
            self._late_at = now  # the next stage ends as long after this one
        return self.level != before

    def reset(self) -> bool:
        """Give up nothing any more; returns whether the level has changed."""
        before, self.level = self.level, 0
        return before != 0

    def report(self, lost: float, now: float) -> str | None:
        """Return a sentence for people, where there is something to report and none was returned within a minute.

        Args:
            lost: Robot time lost since the start, s.
            now: Wall time on a steady clock, s.
        """
        has_news = lost > self._reported_lost or self._worst > 1
        if not has_news or (self._reported_at is not None and now - self._reported_at < REPORT_PERIOD):
            return None
        new, given_up = lost - self._reported_lost, STAGES[: self._worst]
        self._reported_at, self._reported_lost, self._worst = now, lost, self.level
        parts = [f"{new:.1f} s of robot time were lost ({lost:.1f} s since the start)"] if new else []
        parts += [f"given up for a while: {', '.join(given_up)}"] if given_up else []
        return f"the machine is too busy: {'; '.join(parts)}"

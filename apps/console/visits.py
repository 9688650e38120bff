"""One page that a browser has opened."""

import asyncio
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field

_MOST_OUTCOMES = 50


@dataclass(slots=True, eq=False)
class Visit:
    """One page in one browser.

    ticket: secret part of the addresses of its websockets. name: for people. session: with which it was opened; empty
    where no password is asked for. robot: which it shows; empty for none. sockets: by which its browser drives.
    outcomes: of the latest commands, the newest first: time of the day and words. outcome_count: of all of them.
    motions: requests that its browser began; they are cancelled when it is gone. on_end: ends the page itself, when its
    session ends. look_only: why it can command nothing, in words; empty if it can.
    """

    ticket: str
    name: str
    session: str = ""
    robot: str = ""
    sockets: int = 0
    outcomes: deque[tuple[str, str]] = field(default_factory=lambda: deque(maxlen=_MOST_OUTCOMES))
    outcome_count: int = 0
    motions: "set[asyncio.Task[None]]" = field(default_factory=set)
    on_end: Callable[[], None] | None = None
    look_only: str = ""

    @property
    def may_command(self) -> bool:
        """Whether it can command robots and agents."""
        return not self.look_only

    def tell(self, clock: str, words: str) -> None:
        """Note what has happened, at a time of the day."""
        self.outcomes.appendleft((clock, words))
        self.outcome_count += 1

    def cancel_motions(self) -> None:
        """Cancel what it has set in motion."""
        for motion in self.motions:
            motion.cancel()

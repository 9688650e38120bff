"""The outcome of a conversation, for its initiator."""

from dataclasses import dataclass
from enum import StrEnum
from typing import Any

from agents.platform.errors import RequestNotDone


class Ending(StrEnum):
    """How a conversation ended."""

    DONE = "done"
    REFUSED = "refused"  # the peer has refused, and has done nothing
    FAILED = "failed"  # the peer has tried without success
    CANCELLED = "cancelled"  # the peer has stopped on request
    REJECTED = "rejected"  # the peer made a proposal that was not accepted
    NOT_UNDERSTOOD = "not-understood"  # one of the two could not read a message of the other
    TIMED_OUT = "timed out"  # no end in time; a cancel was sent, but the peer may have done it
    NOT_ALLOWED = "not allowed"  # by the role of the own certificate; the peer has not received it
    DIED = "peer died"  # there is no agent of this name, or no longer; it may have done what was requested


@dataclass(frozen=True, slots=True)
class Outcome:
    """The end of a conversation.

    result: what the peer returned; None unless done.
    why: the reason as one sentence; empty if done.
    agreed: whether the peer had agreed before.
    """

    ending: Ending
    result: Any = None
    why: str = ""
    agreed: bool = False

    @property
    def is_done(self) -> bool:
        """Whether it was done."""
        return self.ending is Ending.DONE

    def value(self) -> Any:
        """Return the result.

        Raises:
            RequestNotDone: It was not done; says how it ended and why.
        """
        if not self.is_done:
            raise RequestNotDone(f"{self.ending}: {self.why}")
        return self.result

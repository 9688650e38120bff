"""How a conversation ended, for the one who began it."""

from dataclasses import dataclass
from enum import StrEnum
from typing import Any

from agents.platform.acl import AclMessage
from agents.platform.errors import RequestNotDone


class Ending(StrEnum):
    """How a conversation ended."""

    DONE = "done"
    REFUSED = "refused"  # the other said no, and has done nothing
    FAILED = "failed"  # it tried, in vain
    CANCELLED = "cancelled"  # it was told to leave it, and has
    REJECTED = "rejected"  # it made a proposal, which was not accepted
    NOT_UNDERSTOOD = "not-understood"  # one of the two does not understand the other
    TIMED_OUT = "timed out"  # no end in time; the other has been told to leave it, and may have done it
    NOT_ALLOWED = "not allowed"  # the role of one's certificate does not permit to ask; the other knows nothing of it
    DIED = "peer died"  # nobody of this name is there, or not any more; what was asked may have been done


@dataclass(frozen=True, slots=True)
class Outcome:
    """The end of a conversation.

    result: what the other returned; None unless done.
    why: the reason in one sentence; empty if done.
    agreed: whether the other had agreed before.
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
        """The result.

        Raises:
            RequestNotDone: It was not done; says how it ended and why.
        """
        if not self.is_done:
            raise RequestNotDone(f"{self.ending}: {self.why}")
        return self.result


def why_of(message: AclMessage) -> str:
    """The reason that a no carries, in one sentence."""
    match message.content:
        case {"why": str(why)} if why.strip():
            return why
        case None | {"why": str()}:
            return "no reason is given"
    return str(message.content)

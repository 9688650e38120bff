"""How an agent's life in a container ends, as the container tells it on its reports, for whoever looks after agents."""

from enum import StrEnum


class AgentEnd(StrEnum):
    """Why an agent does not live in its container any more."""

    STOPPED = "stopped"  # on purpose, by itself or by somebody
    CLOSED = "closed"  # with its container, on purpose
    MOVED = "moved"  # it lives on in another container
    FAILED = "failed"  # a behaviour without which it is nothing
    NOT_SET_UP = "not set up"  # its setup raised or took too long

    @property
    def is_failure(self) -> bool:
        """Whether nobody wanted it."""
        return self in (AgentEnd.FAILED, AgentEnd.NOT_SET_UP)

"""What can go wrong among agents.

AgentError
 +-- NameNotValid (ValueError)      a text names no agent
 +-- AclError (ValueError)          a message breaks the rules of ACL
 +-- DescriptionNotValid (ValueError)   what an agent says of itself cannot be read
 +-- IllegalTransition              an agent's life knows no such step from its present state
 +-- UnknownAgent (LookupError)     no such agent lives here
 +-- AlreadyThere                   an agent of this name lives here already
 +-- SetupFailed                    an agent's setup raised or took too long
 +-- NotMoved                       an agent could not move into another container, and lives where it did
 +-- RequestNotDone                 what another agent was asked for was not done
"""

from bus.errors import BusError


class AgentError(Exception):
    """The root: whatever can go wrong among agents."""


class NameNotValid(AgentError, ValueError):
    """A text names no agent."""


class AclError(AgentError, ValueError):
    """A message breaks the rules of ACL."""


class DescriptionNotValid(AgentError, ValueError):
    """What an agent says of itself cannot be read, or is about another one."""


class IllegalTransition(AgentError):
    """An agent's life knows no such step from its present state."""


class UnknownAgent(AgentError, LookupError):
    """No such agent lives here."""


class AlreadyThere(AgentError):
    """An agent of this name lives here already."""


class SetupFailed(AgentError):
    """An agent's setup raised or took too long, so it does not live."""


class NotMoved(AgentError):
    """An agent could not move into another container, and lives where it did."""


class RequestNotDone(AgentError):
    """What another agent was asked for was not done; the message says how it ended and why."""


def in_words(error: BaseException) -> str:
    """An exception as the end of a sentence, never empty.

    The text of our own errors is complete; of other errors the type is given as well, or alone where there is no text.
    """
    text = str(error).strip()
    if isinstance(error, AgentError | BusError) and text:
        return text
    if isinstance(error, TimeoutError) and not text:
        return "a timeout"
    return f"{type(error).__name__}: {text}" if text else type(error).__name__

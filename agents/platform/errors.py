"""Errors of agents.

AgentError
 +-- NameNotValid (ValueError)      a text names no agent
 +-- AclError (ValueError)          a message breaks the rules of ACL
 +-- DescriptionNotValid (ValueError)   what an agent says of itself cannot be read
 +-- IllegalTransition              an agent's life knows no such step from its present state
 +-- UnknownAgent (LookupError)     no such agent lives here
 +-- AlreadyThere                   an agent of this name lives here already
 +-- SetupFailed                    an agent's setup raised or took too long
 +-- RequestNotDone                 what another agent was asked for was not done
"""

from bus.errors import BusError


class AgentError(Exception):
    """Base class of the errors of the agent platform."""


class NameNotValid(AgentError, ValueError):
    """A text is not the name of an agent."""


class AclError(AgentError, ValueError):
    """A message breaks the rules of ACL."""


class DescriptionNotValid(AgentError, ValueError):
    """The description of an agent cannot be read, or describes another agent."""


class IllegalTransition(AgentError):
    """The life cycle of agents has no such transition from the present state."""


class UnknownAgent(AgentError, LookupError):
    """The container has no agent of this name."""


class AlreadyThere(AgentError):
    """The container has an agent of this name already."""


class SetupFailed(AgentError):
    """The setup of an agent raised an error or took too long; the agent was not started."""


class RequestNotDone(AgentError):
    """Another agent has not done what was requested; the message says how the request ended and why."""


def in_words(error: BaseException) -> str:
    """Return an exception as the end of a sentence, never empty.

    Errors of this product are returned as their text; other errors with their type as well.
    """
    text = str(error).strip()
    if isinstance(error, AgentError | BusError) and text:
        return text
    if isinstance(error, TimeoutError) and not text:
        return "a timeout"
    return f"{type(error).__name__}: {text}" if text else type(error).__name__

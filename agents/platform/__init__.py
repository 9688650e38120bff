"""The platform of the agents: names, messages, mailboxes, behaviours, agents and the containers where they live."""

from agents.platform.acl import AclMessage, Performative
from agents.platform.behaviours import (
    Behaviour,
    Cyclic,
    Done,
    FiniteStateMachine,
    NoTransition,
    OneShot,
    Parallel,
    Sequential,
    Ticker,
    Until,
    Waker,
)
from agents.platform.errors import AclError, AgentError, AlreadyThere, IllegalTransition, NameNotValid, UnknownAgent
from agents.platform.mailbox import Mailbox, MailboxState, Template
from agents.platform.names import AgentName
from agents.platform.schedule import DROP, FAIL_AGENT, Failure, Restart, Schedule

__all__ = [
    "DROP",
    "FAIL_AGENT",
    "AclError",
    "AclMessage",
    "AgentError",
    "AgentName",
    "AlreadyThere",
    "Behaviour",
    "Cyclic",
    "Done",
    "Failure",
    "FiniteStateMachine",
    "IllegalTransition",
    "Mailbox",
    "MailboxState",
    "NameNotValid",
    "NoTransition",
    "OneShot",
    "Parallel",
    "Performative",
    "Restart",
    "Schedule",
    "Sequential",
    "Template",
    "Ticker",
    "UnknownAgent",
    "Until",
    "Waker",
]

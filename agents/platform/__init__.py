"""The platform of the agents: names, messages, mailboxes, behaviours, agents and the containers where they live."""

from agents.platform.acl import AclMessage, Performative
from agents.platform.agent import Agent
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
from agents.platform.container.container import Container, Report
from agents.platform.container.context import ContainerContext
from agents.platform.conversations.fipa_contract_net import Bid, Tender
from agents.platform.conversations.fipa_request import Request
from agents.platform.conversations.fipa_subscribe import Values
from agents.platform.conversations.outcome import Ending, Outcome
from agents.platform.conversations.responder_conversation import agree, asker, attended
from agents.platform.directory import Description, Directory
from agents.platform.errors import (
    AclError,
    AgentError,
    AlreadyThere,
    DescriptionNotValid,
    IllegalTransition,
    NameNotValid,
    RequestNotDone,
    SetupFailed,
    UnknownAgent,
)
from agents.platform.hooks import answers, every, on, proposes, request, subscription
from agents.platform.kinds import Kinds, UnknownKind
from agents.platform.life import AgentState, Step
from agents.platform.mailbox import Mailbox, MailboxState, Template
from agents.platform.names import AgentName, ContainerName
from agents.platform.schedule import DROP, FAIL_AGENT, Failure, Restart, Schedule
from agents.platform.synchronizer import Synchronizer, listen_together

__all__ = [
    "DROP",
    "FAIL_AGENT",
    "AclError",
    "AclMessage",
    "Agent",
    "AgentError",
    "AgentName",
    "AgentState",
    "AlreadyThere",
    "Behaviour",
    "Bid",
    "Container",
    "ContainerContext",
    "ContainerName",
    "Cyclic",
    "Description",
    "DescriptionNotValid",
    "Directory",
    "Done",
    "Ending",
    "Failure",
    "FiniteStateMachine",
    "IllegalTransition",
    "Kinds",
    "Mailbox",
    "MailboxState",
    "NameNotValid",
    "NoTransition",
    "OneShot",
    "Outcome",
    "Parallel",
    "Performative",
    "Report",
    "Request",
    "RequestNotDone",
    "Restart",
    "Schedule",
    "Sequential",
    "SetupFailed",
    "Step",
    "Synchronizer",
    "Template",
    "Tender",
    "Ticker",
    "UnknownAgent",
    "UnknownKind",
    "Until",
    "Values",
    "Waker",
    "agree",
    "answers",
    "asker",
    "attended",
    "every",
    "listen_together",
    "on",
    "proposes",
    "request",
    "subscription",
]

"""The platform of the agents: names, messages, mailboxes, behaviours, agents and the containers where they live."""

from agents.platform.acl import AclMessage, Performative
from agents.platform.errors import AclError, AgentError, AlreadyThere, IllegalTransition, NameNotValid, UnknownAgent
from agents.platform.names import AgentName

__all__ = [
    "AclError",
    "AclMessage",
    "AgentError",
    "AgentName",
    "AlreadyThere",
    "IllegalTransition",
    "NameNotValid",
    "Performative",
    "UnknownAgent",
]

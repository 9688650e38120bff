"""Names of agents and containers, and their keys on the bus."""

from dataclasses import dataclass
from typing import Self

from agents.platform.errors import NameNotValid
from bus import KeyNotValid
from bus.keys import robot_name


@dataclass(frozen=True, slots=True, order=True)
class AgentName:
    """The name of an agent, `base@happy`: the local part and the robot (or another platform).

    Raises:
        NameNotValid: A part is not one chunk of a key, or holds another `@`.
    """

    local: str
    platform: str

    def __post_init__(self) -> None:
        for part in (self.local, self.platform):
            _check(part, "an agent's name")

    @classmethod
    def parse(cls, text: str) -> Self:
        """Read `base@happy`.

        Raises:
            NameNotValid: It is not two parts around one `@`, or a part does not serve.
        """
        local, at, platform = text.partition("@") if isinstance(text, str) else ("", "", "")
        if not at:
            raise NameNotValid(f"{text!r} names no agent; a name is written like base@happy")
        return cls(local, platform)

    def __str__(self) -> str:
        return f"{self.local}@{self.platform}"

    @property
    def acl_key(self) -> str:
        """The key for messages to the agent: one-way messages are put, conversations are queries."""
        return self._key("acl")

    @property
    def alive_key(self) -> str:
        """The liveliness token of the agent."""
        return self._key("alive")

    @property
    def description_key(self) -> str:
        """The key of the agent's description, for queries."""
        return self._key("description")

    @property
    def results_key(self) -> str:
        """The key on which it publishes its results as JSON objects."""
        return self._key("results")

    @property
    def heartbeat_key(self) -> str:
        """The key of the agent's heartbeat, which is published while it waits for a motion."""
        return self._key("heartbeat")

    @classmethod
    def of_key(cls, key: str) -> Self:
        """Return the agent to which a key belongs.

        Raises:
            NameNotValid: It is another key.
        """
        match key.split("/"):
            case [platform, "agents", local, "acl" | "alive" | "description" | "heartbeat" | "results"]:
                return cls(local, platform)
        raise NameNotValid(f"{key!r} is no key of an agent")

    def _key(self, suffix: str) -> str:
        return f"{self.platform}/agents/{self.local}/{suffix}"


@dataclass(frozen=True, slots=True, order=True)
class ContainerName:
    """The name of a container, which is unique on the bus, and the robot or team to which it belongs.

    Raises:
        NameNotValid: One of them is not one chunk of a key, or holds an `@`.
    """

    name: str
    platform: str

    def __post_init__(self) -> None:
        for part in (self.name, self.platform):
            _check(part, "a container's name")

    def __str__(self) -> str:
        return self.name

    @property
    def alive_key(self) -> str:
        """The liveliness token of the container."""
        return self._key("alive")

    @property
    def control_key(self) -> str:
        """The key of its control, for queries."""
        return self._key("control")

    @property
    def description_key(self) -> str:
        """The key of its description, for queries that only read."""
        return self._key("description")

    @property
    def said_key(self) -> str:
        """The key on which it publishes the messages of its agents, while a program subscribes to it."""
        return self._key("said")

    @property
    def reports_key(self) -> str:
        """The key on which it publishes errors of its agents."""
        return self._key("reports")

    @classmethod
    def of_key(cls, key: str) -> Self:
        """Return the container to which a key belongs.

        Raises:
            NameNotValid: It is another key.
        """
        match key.split("/"):
            case [platform, "containers", name, "alive" | "control" | "description" | "said" | "reports"]:
                return cls(name, platform)
        raise NameNotValid(f"{key!r} is no key of a container")

    def _key(self, suffix: str) -> str:
        return f"{self.platform}/containers/{self.name}/{suffix}"


PASSER_BY = "ask-"  # prefix of the names of agents that live for one query, and of their containers
ALL_CONTAINERS = "*/containers/*/alive"  # the tokens of all containers on the bus


def _check(part: object, whole: str) -> None:
    """Refuse a part of a name that is not one chunk of a key, or holds an `@`."""
    if not isinstance(part, str):
        raise NameNotValid(f"{whole} is made of two texts, not of {type(part).__name__}")
    if "@" in part:
        raise NameNotValid(f"{part!r} cannot be a part of {whole} because it holds '@'")
    try:
        robot_name(part)
    except KeyNotValid as err:
        raise NameNotValid(str(err).replace("name a robot", f"be a part of {whole}")) from err

"""Names of agents and of the containers where they live, and the keys on the bus where each is found."""

from dataclasses import dataclass
from typing import Self

from agents.platform.errors import NameNotValid
from bus import KeyNotValid
from bus.keys import robot_name


@dataclass(frozen=True, slots=True, order=True)
class AgentName:
    """Who an agent is: `base@happy`, the local part and the robot (or platform) where it lives.

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
        """Where the agent takes messages: one-way ones as a put, conversations as a query."""
        return self._key("acl")

    @property
    def alive_key(self) -> str:
        """The token that is there while the agent lives."""
        return self._key("alive")

    @property
    def description_key(self) -> str:
        """Where the agent says what it is and does."""
        return self._key("description")

    @property
    def results_key(self) -> str:
        """The stream of its results: JSON objects, one each time it has something new to say."""
        return self._key("results")

    @property
    def heartbeat_key(self) -> str:
        """Where the agent's heartbeat beats while it waits for a motion."""
        return self._key("heartbeat")

    @classmethod
    def of_key(cls, key: str) -> Self:
        """The agent to which one of these keys belongs.

        Raises:
            NameNotValid: It is the key of something else.
        """
        match key.split("/"):
            case [platform, "agents", local, "acl" | "alive" | "description" | "heartbeat" | "results"]:
                return cls(local, platform)
        raise NameNotValid(f"{key!r} is no key of an agent")

    def _key(self, suffix: str) -> str:
        return f"{self.platform}/agents/{self.local}/{suffix}"


@dataclass(frozen=True, slots=True, order=True)
class ContainerName:
    """Which container it is: its name, which no other on the bus has, and the robot or team to which it belongs.

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
        """The token that is there while the container lives."""
        return self._key("alive")

    @property
    def control_key(self) -> str:
        """Where it can be told to start and stop agents, and asked about them."""
        return self._key("control")

    @property
    def description_key(self) -> str:
        """Where it says who lives in it, and what one of them holds and does; whoever may look may ask."""
        return self._key("description")

    @property
    def said_key(self) -> str:
        """The stream of all that its agents say; it flows only while somebody listens."""
        return self._key("said")

    @property
    def reports_key(self) -> str:
        """The stream of what goes wrong in it."""
        return self._key("reports")

    @classmethod
    def of_key(cls, key: str) -> Self:
        """The container to which one of these keys belongs.

        Raises:
            NameNotValid: It is the key of something else.
        """
        match key.split("/"):
            case [platform, "containers", name, "alive" | "control" | "description" | "said" | "reports"]:
                return cls(name, platform)
        raise NameNotValid(f"{key!r} is no key of a container")

    def _key(self, suffix: str) -> str:
        return f"{self.platform}/containers/{self.name}/{suffix}"


PASSER_BY = "ask-"  # how the name of an agent begins that lives for one question, and that of its container
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

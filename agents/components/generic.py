"""The agent of an element without a class of its own: its messages as JSON, its commands by their names."""

from collections.abc import Awaitable, Callable, Mapping
from typing import Any

from agents.components.component import ElementAgent
from bus import JSON, keys
from bus.keys import Kind, Topic
from bus.messages import to_json


class Generic(ElementAgent):
    """Results are the messages of the element's first stream as JSON; each command of the robot is a request.

    A request takes the arguments of the command, which the gateway checks.
    """

    @property
    def topic(self) -> Topic | None:
        """The first of the element's streams."""
        known = [keys.topic_of(key) for key in self.properties.get("streams", [])]
        return next((topic for topic in known if topic is not None and topic.type_name != JSON), None)

    async def setup(self) -> None:
        """Subscribe, and register the commands."""
        await super().setup()
        for key in self.properties.get("commands", []):
            topic = keys.topic_of(key)
            if topic is not None and topic.kind is Kind.QUERY:
                self.answer(topic.suffix.rpartition("/")[2], self._passing_on(topic), agrees_itself=True)

    def result(self, message: Any) -> Mapping[str, Any]:
        """Return the message's fields without the header; None for missing numbers."""
        return {name: _plain(value) for name, value in to_json(message).items() if name != "header"}

    def _passing_on(self, topic: Topic) -> Callable[..., Awaitable[dict[str, Any]]]:
        async def pass_on(**arguments: Any) -> dict[str, Any]:
            return await self.command(topic, **arguments)

        pass_on.__doc__ = topic.meaning
        return pass_on


def _plain(value: Any) -> Any:
    """Return a value with None in place of the texts for numbers that JSON lacks."""
    match value:
        case "inf" | "-inf" | "nan":
            return None
        case list():
            return [_plain(item) for item in value]
        case dict():
            return {name: _plain(item) for name, item in value.items()}
    return value

"""The panel that looks into an agent: mailbox, behaviours, streams and conversations."""

from collections.abc import Mapping
from typing import Any

from nicegui import ui

from agents.platform import AgentError
from agents.platform.containers import read
from agents.platform.errors import in_words
from apps.console.agent_watch import WatchedAgent
from apps.console.data_view import DataTable
from apps.console.program import Console
from bus import BusError

Row = Mapping[str, Any]


class InsidePanel:
    """What an agent holds and does, read again and again while it is shown."""

    def __init__(self, console: Console) -> None:
        """Add it to the page."""
        self._console = console
        self._words = ui.label().classes("c-quiet")
        self._tables: dict[str, DataTable] = {}
        for name, titles, empty in _TABLES:
            with ui.element("h3"):
                ui.label(name)
            self._tables[name] = DataTable(titles, empty)

    async def refresh(self, agent: WatchedAgent) -> None:
        """Look into an agent."""
        try:
            seen = await read(self._console.agent.bus, agent.container, "introspect", name=str(agent.name))
            tables = inside_rows(seen)
            box, malformed = seen["mailbox"], seen["malformed"]
        except (KeyError, TypeError):
            self._words.text = f"the container {agent.container} answers nonsense"
            return
        except (AgentError, BusError, TimeoutError) as err:
            self._words.text = f"not known: {in_words(err)}"
            return
        counts = ", ".join(f"{box.get(name)} {name}" for name in ("waiting", "delivered", "dropped"))
        self._words.text = f"messages: {counts}, {malformed} malformed"
        for name, rows in tables.items():
            self._tables[name].show(rows)


_TABLES = (
    ("Mailbox", ("Performative", "From", "Protocol", "Content"), "no message waits"),
    ("Behaviours", ("Name", "Kind", "Failures", "After a failure"), "none"),
    ("Streams", ("Key", "Skipped", "Failures"), "none"),
    ("Conversations that it answers", ("Performative", "From", "Protocol", "Content", "Agreed"), "none"),
)


def inside_rows(seen: Row) -> dict[str, list[list[str]]]:
    """Return the rows of the tables, by their headings, from the answer to `introspect`.

    Raises:
        KeyError, TypeError: It is no such answer.
    """
    return {
        "Mailbox": [_message(row) for row in seen["mailbox"]["oldest"]],
        "Behaviours": [_texts(row, "name", "kind", "failures", "policy") for row in seen["behaviours"]],
        "Streams": [_texts(row, "key", "skipped", "failures") for row in seen["streams"]],
        "Conversations that it answers": [
            [*_message(row), "yes" if row["agreed"] else "no"] for row in seen["in_flight"]
        ],
    }


def _message(row: Row) -> list[str]:
    return _texts(row, "performative", "sender", "protocol", "content")


def _texts(row: Row, *names: str) -> list[str]:
    return [str(row[name]) for name in names]

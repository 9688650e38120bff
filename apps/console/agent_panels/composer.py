"""The panel in which any ACL message is composed and sent, with the replies."""

import asyncio
import time
from collections import deque
from collections.abc import Mapping
from contextlib import aclosing
from typing import Any

from nicegui import ui

from agents.platform import AgentError, AgentName, Template
from agents.platform.acl import AclMessage
from agents.platform.conversations.any_message import MessageDraft, converse
from agents.platform.errors import in_words
from agents.sniffer.captured import brief, shortened
from apps.console.agent_control import why_not_ask
from apps.console.agent_panels.pulse import BrowserPulse
from apps.console.composing import PERFORMATIVES, DraftNotValid, draft_of
from apps.console.data_view import DataTable
from apps.console.program import Console
from apps.console.visits import Visit
from bus import BusError

_WAIT = 10.0  # s for replies, unless the message has a reply-by
_MOST = 100  # replies shown
_LONGEST = 2000  # characters of a content
_EXAMPLE = '{"action": "read", "arguments": {}}'
_TITLES = {
    "protocol": "Protocol",
    "conversation": "Conversation",
    "language": "Language",
    "ontology": "Ontology",
    "reply_with": "Reply with",
    "in_reply_to": "In reply to",
}


class ComposerPanel:
    """Fields of a message, a button to send it, and the replies."""

    def __init__(self, console: Console, visit: Visit, pulse: BrowserPulse) -> None:
        """Add it to the page. pulse: of its browser."""
        self._console, self._visit, self._pulse = console, visit, pulse
        self._replies: deque[tuple[str, str, str, str]] = deque(maxlen=_MOST)
        self._sending: asyncio.Task[None] | None = None
        self._inputs: dict[str, Any] = {}
        with ui.element("div").classes("c-form"):
            self._inputs["performative"] = ui.select(PERFORMATIVES, value="request", label="Performative")
            self._inputs["receivers"] = ui.input("Receivers", placeholder="base@happy, laser@happy")
            self._inputs["reply_by"] = ui.input("Reply by, s from now", placeholder="none")
        self._inputs["content"] = ui.textarea("Content, JSON", value=_EXAMPLE).props("autogrow input-class=a-code")
        with ui.element("details"):
            with ui.element("summary"):
                ui.label("More fields").classes("a-inline")
            with ui.element("div").classes("c-form"):
                for name, title in _TITLES.items():
                    self._inputs[name] = ui.input(title, placeholder="chosen" if name in _CHOSEN else "none")
        for each in self._inputs.values():
            each.props("dense stack-label")
        with ui.row().classes("rv-row"):
            self._send = ui.button("Send", on_click=self._begin).props("dense no-caps")
            self._stop = ui.button("Stop waiting", on_click=self._end).props("outline dense no-caps")
        self._words = ui.label().props('role="status"').classes("a-words")
        self._table = DataTable(("Time", "From", "Performative", "Content"), "no reply yet")
        self._table.set_visibility(False)
        self._stop.set_visibility(False)

    def show(self, agent: AgentName) -> None:
        """Address the message to an agent."""
        self._inputs["receivers"].value = str(agent)
        self.refresh(agent)

    def refresh(self, agent: AgentName) -> None:
        """Enable what is possible now."""
        why_not = why_not_ask(self._console, self._visit, agent)
        is_sending = self._sending is not None and not self._sending.done()
        self._send.set_enabled(not why_not and not is_sending)
        self._stop.set_visibility(is_sending)
        if why_not:
            self._words.text = why_not

    def _begin(self) -> None:
        if not self._send.enabled:
            return
        try:
            draft = draft_of({name: str(each.value or "") for name, each in self._inputs.items()})
        except DraftNotValid as err:
            self._words.text = f"Not sent: {err}"
            return
        self._replies.clear()
        self._table.set_visibility(True)
        self._table.show([])
        self._sending = self._pulse.begin(self._exchange(draft))

    def _end(self) -> None:
        if self._sending is not None:
            self._sending.cancel()

    async def _exchange(self, draft: MessageDraft) -> None:
        message = draft.message(self._console.agent)
        within = draft.reply_by or _WAIT
        self._words.text = f"sent; replies are waited for {within:g} s"
        try:
            if draft.begins_conversation:
                ends = await asyncio.gather(*(self._converse(message, each, within) for each in draft.receivers))
                self._words.text = "; ".join(ends)
            else:
                self._console.agent.send(message)
                await self._hear(message, within)
        except (AgentError, BusError) as err:
            self._words.text = f"Not sent: {in_words(err)}"
        except asyncio.CancelledError:
            self._words.text = "replies are not waited for any more"
            raise
        self._console.say(self._visit, f"{draft.performative} to {', '.join(map(str, draft.receivers))} was sent")

    async def _converse(self, message: AclMessage, receiver: AgentName, within: float) -> str:
        """Show the replies of one receiver; return how the conversation ended."""
        count = 0
        try:
            async with aclosing(converse(self._console.agent, message, receiver, within)) as replies:
                async for reply in replies:
                    count += 1
                    self._show(reply)
        except (BusError, TimeoutError) as err:
            return f"{receiver}: {in_words(err)}"
        return f"{receiver}: ended after {_counted(count)}"

    async def _hear(self, message: AclMessage, within: float) -> None:
        """Show what comes into the mailbox for a while."""
        count = 0
        try:
            async with asyncio.timeout(within):
                while True:
                    reply = await self._console.agent.receive(Template.of(conversation=message.conversation_id))
                    self._show(reply.to_dict())
                    count += 1
        except TimeoutError:
            self._words.text = f"{_counted(count)} came within {within:g} s"

    def _show(self, reply: Mapping[str, Any]) -> None:
        sender, performative = (shortened(str(reply.get(name, "?")), 120) for name in ("sender", "performative"))
        clock = time.strftime("%H:%M:%S")
        self._replies.append((clock, sender, performative, brief(reply.get("content"), _LONGEST)))
        self._table.show(list(self._replies))


def _counted(count: int) -> str:
    return "no reply" if not count else "1 reply" if count == 1 else f"{count} replies"


_CHOSEN = ("protocol", "conversation", "reply_with")

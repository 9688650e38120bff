"""The panel of the sniffer: the messages between agents as a live sequence diagram."""

import time

from nicegui import ui
from nicegui.element import Element
from nicegui.events import GenericEventArguments

from agents.sniffer.captured import Unreadable
from apps.console.data_view import text_of
from apps.console.program import Console
from apps.console.visits import Visit
from apps.web.viewer import SHARED

SNIFFER_PATH = "/messages"


class SequenceDiagram(Element, component="sequence.js", esm=SHARED):
    """The diagram. Event: `open` {number}, a message that was chosen."""

    def __init__(self, visit: Visit) -> None:
        """Add it to the page."""
        super().__init__()
        self._props["path"] = f"{SNIFFER_PATH}/{visit.ticket}"
        self._props["opened"] = 0

    def open(self, number: int) -> None:
        """Mark a message."""
        self._props["opened"] = number

    def filter(self, agent: str) -> None:
        """Show the messages of one agent."""
        self.run_method("filterBy", agent)


class ConversationsPanel:
    """The diagram, and the content of the message that was chosen in it."""

    def __init__(self, console: Console, visit: Visit) -> None:
        """Add it to the page."""
        self._console = console
        self.diagram = SequenceDiagram(visit)
        self.diagram.on("open", self._open)
        with ui.element("div").classes("a-message").props('role="status"') as self._box:
            with ui.row().classes("rv-row"):
                self._title = ui.label().classes("c-strong c-grow")
                ui.button(icon="close", on_click=self._close).props('flat round dense aria-label="Close the message"')
            self._text = ui.label().classes("c-log")
        self._box.set_visibility(False)

    def _open(self, event: GenericEventArguments) -> None:
        number = event.args.get("number")
        heard = self._console.sniffer.log.find(number) if isinstance(number, int) else None
        self._box.set_visibility(True)
        self.diagram.open(number if isinstance(number, int) else 0)
        if heard is None:
            self._title.text, self._text.text = "This message is not kept any more.", ""
            return
        clock = time.strftime("%H:%M:%S", time.localtime(heard.time))
        if isinstance(heard, Unreadable):
            self._title.text = f"{clock}, {heard.size} bytes of {heard.container} are unreadable"
            self._text.text = heard.why
            return
        message = heard.message
        who = f"{message.sender} to {', '.join(map(str, message.receivers)) or 'nobody'}"
        self._title.text = f"{clock}, {message.performative}, {who}"
        self._text.text = text_of(message.to_dict())

    def _close(self) -> None:
        self._box.set_visibility(False)
        self.diagram.open(0)

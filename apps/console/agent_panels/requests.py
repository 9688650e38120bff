"""The panel with a form for everything that an agent can be asked for."""

import asyncio
from collections.abc import Mapping
from typing import Any

from nicegui import ui

from agents.platform import AgentError, AgentName, Performative
from agents.platform.containers import read
from agents.platform.errors import in_words
from apps.console.agent_control import why_not_ask
from apps.console.agent_panels.pulse import BrowserPulse
from apps.console.agent_watch import WatchedAgent
from apps.console.data_view import DataView
from apps.console.program import Console
from apps.console.request_form import FieldNotValid, FormField, arguments_of, entries_of, fields_of
from apps.console.visits import Visit
from bus import BusError

_BY_FORM = ("requests", "answers", "subscriptions")  # a call for proposals has several receivers: see the composer
_WITHIN = 30.0  # s for a request, at first


class RequestPanel:
    """A form that is made from the interface of the agent, and the reply."""

    def __init__(self, console: Console, visit: Visit, pulse: BrowserPulse) -> None:
        """Add it to the page. pulse: of its browser."""
        self._console, self._visit, self._pulse = console, visit, pulse
        self._name: AgentName | None = None
        self._entries: dict[str, tuple[str, Mapping[str, Any]]] = {}
        self._fields: list[FormField] = []
        self._inputs: dict[str, Any] = {}
        self._running: asyncio.Task[None] | None = None
        self._built: tuple[AgentName, str] | None = None  # agent and request of the form
        self._agent: WatchedAgent | None = None
        self._select = ui.select([], label="Ask it to", on_change=self._build).props("dense").classes("rv-select")
        self._doc = ui.label().classes("c-quiet a-doc")
        self._form = ui.element("div").classes("c-form")
        with ui.row().classes("rv-row"):
            self._ask = ui.button("Ask", on_click=self._begin).props("dense no-caps")
            self._cancel = ui.button("Cancel", on_click=self._end).props("outline dense no-caps color=negative")
            self._within = ui.number("Within, s", value=_WITHIN, min=0.1).props("dense").classes("rv-field")
        self._words = ui.label().props('role="status"').classes("a-words")
        self._again = ui.button("Try again", icon="refresh", on_click=self._show_again).props("outline dense no-caps")
        self._view = DataView()
        self._cancel.set_visibility(False)
        self._again.set_visibility(False)

    async def show(self, agent: WatchedAgent) -> None:
        """Show the forms of another agent."""
        self._name, self._agent = agent.name, agent
        self._view.hide()
        self._again.set_visibility(False)
        self._offer({})  # not those of another agent, while this one is asked
        self._tell("asking what it can be asked for …")
        why = ""
        try:
            told = await read(self._console.agent.bus, agent.container, "interface", name=str(agent.name))
        except TimeoutError:
            why = f"its container {agent.container} has not answered what it can be asked for"
        except (AgentError, BusError) as err:
            why = f"what it can be asked for is not known: {in_words(err)}"
        if self._agent is not agent:
            return  # another one was chosen meanwhile
        self._again.set_visibility(bool(why) and self._console.replay is None)
        self._offer({} if why else entries_of(told, _BY_FORM))
        self._tell(why or ("" if self._entries else "It answers no requests."), is_good=not why)
        self.refresh()

    async def _show_again(self) -> None:
        if self._agent is not None:
            await self.show(self._agent)

    def _offer(self, entries: dict[str, tuple[str, Mapping[str, Any]]]) -> None:
        """Offer requests, and show the form of the first one."""
        self._entries, self._built = entries, None
        self._select.set_options(list(entries), value=next(iter(entries), None))
        self._build()  # for a choice that has the same name as the one before, which is no change of it

    def refresh(self) -> None:
        """Enable what is possible now."""
        why_not = why_not_ask(self._console, self._visit, self._name) if self._name is not None else "choose an agent"
        is_running = self._running is not None and not self._running.done()
        self._ask.set_enabled(not why_not and not is_running and bool(self._entries))
        self._cancel.set_visibility(is_running)
        if why_not:
            self._tell(why_not, is_good=False)

    def _build(self) -> None:
        """Make the fields of the chosen request, unless they are there."""
        request = str(self._select.value)
        if self._name is None or self._built == (self._name, request):
            return
        self._built = self._name, request
        kind, entry = self._entries.get(request, ("", {"doc": "", "parameters": []}))
        self._fields, self._inputs = fields_of(entry), {}
        self._doc.text = str(entry["doc"])
        self._within.set_visibility(kind != "subscriptions")
        self._form.clear()
        with self._form:
            for field in self._fields:
                self._inputs[field.name] = self._input(field)

    def _input(self, field: FormField) -> Any:
        if field.widget == "choice":
            made: Any = ui.select(list(field.choices), label=field.name, clearable=not field.is_required)
        elif field.widget == "json":
            made = ui.textarea(field.name).props("autogrow")
        else:
            made = ui.input(field.name).on("keydown.enter", self._begin)
            if field.widget == "number":
                made.props("inputmode=decimal")
        made.props("dense stack-label bottom-slots")
        made.props["hint"] = field.hint
        return made

    def _begin(self) -> None:
        if not self._ask.enabled or self._name is None or str(self._select.value) not in self._entries:
            return
        kind, entry = self._entries[str(self._select.value)]
        try:
            given = arguments_of(self._fields, {name: each.value for name, each in self._inputs.items()})
        except FieldNotValid as err:
            self._tell(f"Not sent: {err}", is_good=False)
            return
        follow = self._follow if kind == "subscriptions" else self._request
        self._view.hide()
        self._running = self._pulse.begin(follow(self._name, kind, str(entry["name"]), given))
        self.refresh()

    def _end(self) -> None:
        if self._running is not None:
            self._running.cancel()

    async def _request(self, agent: AgentName, kind: str, request: str, given: Mapping[str, Any]) -> None:
        self._tell(f"{request}: asked …")
        within = float(self._within.value or _WITHIN)
        performative = Performative.REQUEST if kind == "requests" else Performative.QUERY_REF
        try:
            begin = self._console.agent.initiator.conversation
            outcome = await begin(performative, agent, request, given, within, within).outcome()
            words = "done" if outcome.is_done else f"{outcome.ending}: {outcome.why}"
            self._tell(f"{request}: {words}", is_good=outcome.is_done)
            if outcome.is_done:
                self._view.show(outcome.result)
            self._console.say(self._visit, f"{agent} {request}: {words}")
        except (AgentError, BusError) as err:
            self._tell(f"{request}: {in_words(err)}", is_good=False)
        except asyncio.CancelledError:
            self._tell(f"{request}: cancelled", is_good=False)
            raise

    async def _follow(self, agent: AgentName, kind: str, name: str, given: Mapping[str, Any]) -> None:
        self._tell(f"{name}: subscribed; no value has come yet")
        count = 0
        try:
            async with self._console.agent.subscribe(agent, name, keep=1, **given) as values:
                async for value in values:
                    count += 1
                    self._tell(f"{name}: {count} values, the newest:")
                    self._view.show(value)
            self._tell(f"{name}: ended after {count} values")
        except (AgentError, BusError) as err:
            self._tell(f"{name}: {in_words(err)}", is_good=False)
        except asyncio.CancelledError:
            self._tell(f"{name}: cancelled after {count} values")
            raise

    def _tell(self, words: str, is_good: bool = True) -> None:
        self._words.text = words
        self._words.classes(add="" if is_good else "c-alarmed", remove="c-alarmed" if is_good else "")

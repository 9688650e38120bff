"""The panel of one agent: its state, and suspending, resuming, moving and stopping it."""

from collections.abc import Callable

from nicegui import ui

from apps.console.agent_control import control, why_not_control
from apps.console.agent_watch import SUSPENDED, WatchedAgent
from apps.console.program import Console
from apps.console.visits import Visit


class StatePanel:
    """Where an agent lives, and in which state."""

    def __init__(self, console: Console, visit: Visit, show_messages: Callable[[], None]) -> None:
        """Add it to the page. show_messages: shows the messages of the chosen agent only."""
        self._console, self._visit = console, visit
        self._agent: WatchedAgent | None = None
        with ui.element("dl").classes("c-facts"):
            self._facts = {}
            for title in ("State", "Container", "Kind", "Services"):
                with ui.element("dt"):
                    ui.label(title)
                with ui.element("dd"):
                    self._facts[title] = ui.label()
        with ui.row().classes("rv-row"):
            self._suspend = ui.button("Suspend", on_click=lambda: self._do("suspend"))
            self._resume = ui.button("Resume", on_click=lambda: self._do("resume"))
            self._move = ui.button("Move …", on_click=self._ask_where)
            self._clone = ui.button("Clone …", on_click=self._ask_name)
            self._stop = ui.button("Stop …", on_click=self._ask_stop).props("color=negative")
            for button in (self._suspend, self._resume, self._move, self._clone, self._stop):
                button.props("outline dense no-caps")
            ui.button("Its messages", on_click=show_messages).props("flat dense no-caps")
        self._why_not = ui.label().classes("c-quiet")

    def refresh(self, agent: WatchedAgent) -> None:
        """Show an agent."""
        self._agent = agent
        services = agent.description.services if agent.description is not None else ()
        self._facts["State"].text = agent.state
        self._facts["Container"].text = f"{agent.container.name} of {agent.container.platform}"
        self._facts["Kind"].text = agent.kind
        self._facts["Services"].text = ", ".join(services) or "none"
        why_not = why_not_control(self._console, self._visit, agent.container)
        self._why_not.text = why_not
        self._why_not.set_visibility(bool(why_not))
        self._suspend.set_visibility(agent.state != SUSPENDED)
        self._resume.set_visibility(agent.state == SUSPENDED)
        for button in (self._suspend, self._resume, self._move, self._clone, self._stop):
            button.set_enabled(not why_not)

    async def _do(self, do: str, **given: str) -> None:
        if self._agent is not None:
            ui.notify(await control(self._console, self._visit, self._agent, do, **given))

    async def _ask_stop(self) -> None:
        agent = self._agent
        if agent is None:
            return
        with ui.dialog() as dialog, ui.card().classes("c-dialog"):
            ui.label(f"Stop {agent.name}?").classes("rv-heading")
            ui.label("It ends its conversations and behaviours. What it set in motion stops.")
            with ui.row().classes("rv-row"):
                ui.button("Stop it", on_click=lambda: dialog.submit(True)).props("no-caps color=negative")
                ui.button("Keep it", on_click=lambda: dialog.submit(False)).props("no-caps flat")
        if await dialog:
            await self._do("stop")
        dialog.delete()

    async def _ask_where(self) -> None:
        agent = self._agent
        if agent is None:
            return
        here = agent.container.name, self._console.agent.home.name
        others = [name for name in sorted(self._console.agents.reports) if name not in here]
        with ui.dialog() as dialog, ui.card().classes("c-dialog"):
            ui.label(f"Move {agent.name} to another container").classes("rv-heading")
            if others:
                where = ui.select(others, value=others[0], label="Container").props("dense").classes("rv-select")
                ui.label("It keeps its state, and the messages that wait for it.").classes("c-quiet")
            else:
                ui.label("There is no other container; start one with: acromovi container")
            with ui.row().classes("rv-row"):
                if others:
                    ui.button("Move it", on_click=lambda: dialog.submit(where.value)).props("no-caps")
                ui.button("Keep it here", on_click=lambda: dialog.submit("")).props("no-caps flat")
        if to := await dialog:
            await self._do("move", to=str(to))
        dialog.delete()

    async def _ask_name(self) -> None:
        agent = self._agent
        if agent is None:
            return
        with ui.dialog() as dialog, ui.card().classes("c-dialog"):
            ui.label(f"Clone {agent.name}").classes("rv-heading")
            name = ui.input("Name of the copy", value=f"{agent.name.local}-2@{agent.name.platform}").props("dense")
            ui.label(f"It is started in {agent.container.name} with the state of the agent.").classes("c-quiet")
            with ui.row().classes("rv-row"):
                ui.button("Clone it", on_click=lambda: dialog.submit(name.value)).props("no-caps")
                ui.button("Do not clone it", on_click=lambda: dialog.submit("")).props("no-caps flat")
        if copy := await dialog:
            await self._do("clone", **{"as": str(copy)})
        dialog.delete()

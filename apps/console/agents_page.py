"""The page Agents: the tree of containers and agents, what an agent can be asked for, and what agents send."""

from nicegui import ui
from nicegui.element import Element
from nicegui.events import GenericEventArguments

from apps.console.agent_panels.composer import ComposerPanel
from apps.console.agent_panels.conversations import ConversationsPanel
from apps.console.agent_panels.inside import InsidePanel
from apps.console.agent_panels.leases import LeasesPanel
from apps.console.agent_panels.pulse import BrowserPulse
from apps.console.agent_panels.requests import RequestPanel
from apps.console.agent_panels.state import StatePanel
from apps.console.agent_tree import tree_of
from apps.console.agent_watch import WatchedAgent
from apps.console.data_view import DataTable, table_of
from apps.console.outcomes import OutcomeList
from apps.console.page import panel
from apps.console.program import Console
from apps.console.visits import Visit

_REFRESH = 1.0  # s
_TABS = ("Ask", "Inside", "Properties", "Message")


class _AgentTree(Element, component="agent_tree.js"):
    """The tree. Event: `choose` {name}."""

    def show(self, sites: list[dict[str, object]], chosen: str, detailed: bool, empty: str) -> None:
        """Show sites, and which agent is chosen. detailed: with properties. empty: shown in place of sites."""
        self._props["sites"] = sites
        self._props["chosen"] = chosen
        self._props["detailed"] = detailed
        self._props["empty"] = empty


def build(console: Console, visit: Visit) -> None:
    """Build the page."""
    _AgentsPage(console, visit)


class _AgentsPage:
    def __init__(self, console: Console, visit: Visit) -> None:
        self._console = console
        self._chosen = ""
        self._shown: tuple[object, ...] = ()
        with ui.element("h1").classes("c-unseen"):
            ui.label("Agents")
        with ui.element("div").classes("a-page"):
            with panel("Agents", "a-side"):
                self._search = ui.input(
                    "Search", placeholder="laser  service=sonar  state=suspended", on_change=self._show
                )
                self._search.props('dense clearable stack-label hint="name, service, request, or property=value"')
                self._detailed = ui.checkbox("Properties", on_change=self._show).props("dense")
                self._tree = _AgentTree()
                self._tree.on("choose", self._choose)
            with ui.element("div").classes("c-stack"):
                with panel("Agent") as box:
                    self._add_agent(visit)
                box.props('aria-label="The chosen agent"')
                with panel("Conversations"):
                    self._conversations = ConversationsPanel(console, visit)
                with ui.element("div").classes("c-columns"):
                    with panel("Leases"):
                        self._leases = LeasesPanel(console, visit)
                    with panel("Outcomes"):
                        OutcomeList(visit)
        self._show()
        ui.timer(_REFRESH, self._refresh)

    def _add_agent(self, visit: Visit) -> None:
        self._title = ui.label("Choose an agent in the list.").classes("a-title")
        with ui.element("div").classes("c-stack") as self._about:
            pulse = BrowserPulse(visit, self._console.settings.drive.release_s)
            self._state = StatePanel(self._console, visit, lambda: self._conversations.diagram.filter(self._chosen))
            with ui.tabs().props("dense no-caps align=left inline-label") as self._tabs:
                for each in _TABS:
                    ui.tab(each)
            with ui.tab_panels(self._tabs, value=_TABS[0], keep_alive=True).classes("a-panels").props("animated=false"):
                with ui.tab_panel("Ask"):
                    self._requests = RequestPanel(self._console, visit, pulse)
                with ui.tab_panel("Inside"):
                    self._inside = InsidePanel(self._console)
                with ui.tab_panel("Properties"):
                    self._properties = DataTable(("Name", "Value"), "it has no properties")
                with ui.tab_panel("Message"):
                    self._composer = ComposerPanel(self._console, visit, pulse)
        self._about.set_visibility(False)

    @property
    def _agent(self) -> WatchedAgent | None:
        return self._console.agents.agents.get(self._chosen)

    async def _choose(self, event: GenericEventArguments) -> None:
        name = event.args.get("name")
        self._chosen = name if isinstance(name, str) else ""
        self._show()
        if (agent := self._agent) is not None:
            self._composer.show(agent.name)
            await self._requests.show(agent)
            await self._refresh()

    async def _refresh(self) -> None:
        await self._console.agents.refresh()
        self._show()
        if (agent := self._agent) is not None:
            self._requests.refresh()
            self._composer.refresh(agent.name)
            if self._tabs.value == "Inside":
                await self._inside.refresh(agent)
        await self._leases.refresh()

    def _show(self) -> None:
        """Show the tree and the chosen agent, if something has changed."""
        watch = self._console.agents
        search = self._search.value or ""
        shown = (watch.changes, len(watch.silent), search, self._detailed.value, self._chosen)
        if shown == self._shown:
            return
        self._shown = shown
        sites = tree_of(watch.reports.values(), watch.silent, watch.agents, search)
        nobody = "no agent fits the search" if search else "no agent is on the bus yet; start a team: acromovi up TEAM"
        self._tree.show(sites, self._chosen, bool(self._detailed.value), nobody)
        agent = self._agent
        self._about.set_visibility(agent is not None)
        if agent is not None:
            self._title.text = str(agent.name)
            self._state.refresh(agent)
            properties = agent.description.properties if agent.description is not None else {}
            table = table_of(properties)
            self._properties.show(table[1] if table is not None else [])
        elif self._chosen:
            self._title.text = f"{self._chosen} is not on the bus any more."

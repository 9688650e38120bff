"""The page Applications: start one with its arguments, stop it, read its output."""

from nicegui import ui

from apps.console.applications import ApplicationRun
from apps.console.page import panel
from apps.console.program import Console
from apps.console.visits import Visit

_REFRESH = 0.5  # s
_ENDED = {0: "ended", 143: "stopped", -9: "killed"}  # by exit code


def build(console: Console, visit: Visit) -> None:
    """Build the page."""
    _ApplicationsPage(console, visit)


class _ApplicationsPage:
    def __init__(self, console: Console, visit: Visit) -> None:
        self._console, self._visit = console, visit
        self._known = {app.name: app for app in console.applications.known()}
        self._fields: dict[str, ui.input] = {}
        self._shown: tuple[object, ...] = ()
        self._chosen: ApplicationRun | None = None
        self._logged = (-1, -1)
        with ui.element("div").classes("c-columns"):
            with ui.element("div").classes("c-stack"):
                with panel("Start an application"):
                    self._select = ui.select(sorted(self._known), label="Application", on_change=self._ask)
                    self._about = ui.label().classes("c-quiet")
                    self._form = ui.element("div").classes("c-form")
                    self._start = ui.button("Start", on_click=self._begin).props("dense no-caps")
                    self._trouble = ui.label().classes("c-alarmed").props('role="alert"')
                with panel("Runs"):
                    self._runs = ui.element("ul").classes("c-plain c-runs")
            with panel("Output"):
                self._title = ui.label().classes("c-quiet")
                self._log = ui.label().classes("c-log").props('role="log" tabindex="0" aria-label="Output"')
        self._ask()
        self._refresh()
        ui.timer(_REFRESH, self._refresh)

    def _ask(self) -> None:
        """Show what the chosen application takes."""
        self._form.clear()
        self._fields = {}
        app = self._known.get(str(self._select.value))
        self._about.text = app.about if app is not None else "Choose one; its arguments are asked for here."
        self._trouble.text = ""
        self._start.set_enabled(app is not None and self._visit.may_command)
        if app is None:
            return
        robots = [robot.name for robot in self._console.robots.robots.values() if robot.is_there]
        with self._form:
            for name, usual in app.parameters.items():
                about = f"usually {usual}" if usual else "may be left out"
                field = ui.input(
                    name, placeholder=about, autocomplete=robots if "robot" in name or name == "leader" else None
                )
                self._fields[name] = field.props("dense stack-label")

    async def _begin(self) -> None:
        given = {name: field.value.strip() for name, field in self._fields.items() if (field.value or "").strip()}
        try:
            self._chosen = await self._console.applications.start(str(self._select.value), given)
        except (ValueError, OSError) as err:
            self._trouble.text = f"It was not started: {err}"
            return
        self._trouble.text = ""
        self._console.timeline.tell("console", self._visit.name, f"{self._chosen.name} was started")

    async def _stop(self, run: ApplicationRun) -> None:
        """Do what the button says: stop it, or kill it while it is being stopped."""
        if run.is_stopping:
            self._console.applications.kill(run)
            return
        self._console.timeline.tell("console", self._visit.name, f"{run.name} was stopped")
        await self._console.applications.stop(run)

    def _choose(self, run: ApplicationRun) -> None:
        self._chosen = run
        self._shown = ()

    def _refresh(self) -> None:
        runs = self._console.applications.runs
        shown = (self._chosen, *((run.number, run.is_stopping, run.code) for run in runs))
        if shown != self._shown:
            self._shown = shown
            self._runs.clear()
            with self._runs:
                if not runs:
                    ui.label("no application has been started from the console").classes("c-quiet")
                for run in reversed(runs):
                    self._add(run)
        self._show_output()

    def _add(self, run: ApplicationRun) -> None:
        with ui.element("li").classes("c-run"):
            ended = _ENDED.get(run.code or 0, f"failed ({run.code})")
            state = ended if not run.is_running else "stopping …" if run.is_stopping else "running"
            link = ui.button(f"{run.name} {' '.join(run.words)}", on_click=lambda: self._choose(run))
            link.props("flat dense no-caps align=left").classes("c-grow")
            ui.label(state).classes("c-fine" if run.is_running else "c-quiet")
            if run.is_running:
                what = "Kill" if run.is_stopping else "Stop"
                stop = ui.button(what, on_click=lambda: self._stop(run)).props("outline dense no-caps color=negative")
                stop.set_enabled(self._visit.may_command)

    def _show_output(self) -> None:
        run = self._chosen
        if run is None:
            self._title.text = "Choose a run to read its output."
            return
        if self._logged == (run.number, run.line_count):
            return
        self._logged = run.number, run.line_count
        self._title.text = f"{run.name}, the newest lines last"
        self._log.text = "\n".join(run.lines) or "nothing has been printed yet"

"""The frame of all pages: the robots and their state, the red button, navigation, theme."""

import asyncio
import html
from collections.abc import Sequence
from functools import partial
from math import isfinite
from pathlib import Path

from nicegui import Client, ui
from nicegui.element import Element

from apps.console.health import standing
from apps.console.page import ConsolePage
from apps.console.program import Console
from apps.console.replay_bar import ReplayBar
from apps.console.visits import Visit
from apps.web.access import COOKIE
from apps.web.certificates import expiry_of, owner_of, why_expired, why_look_only
from apps.web.viewer import STYLE
from bus import keys

CONSOLE_STYLE = Path(__file__).with_name("console.css")
STOP_PATH, SESSION_PATH = "/stop", "/session.txt"
_THEME = "acromovi-theme"  # cookie
_YEAR = 31_536_000  # s
_REFRESH = 0.3  # s
_PARTING = 0.5  # s for a page to hear that its session has ended


_ENDED = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>Ended · Acromovi</title><style>
:root { color-scheme: light dark; font-family: Roboto, system-ui, sans-serif; }
body { margin: 0; min-height: 100vh; display: grid; place-items: center; background: Canvas; color: CanvasText; }
main { width: min(420px, 88vw); padding: 28px; border: 1px solid #8886; border-radius: 10px; }
h1 { margin: 0 0 12px; font-size: 22px; }
</style></head><body><main><h1>This page has ended</h1><p role="alert">WORDS</p>
<p>What it drove was stopped, and its leases were released.</p>
<p><a href="ORIGIN/">Open the console again</a></p></main></body></html>"""


class StopButton(Element, component="stop_button.js"):
    """The red button. It asks the console by a request of its own, and does not depend on the page's websocket."""

    def __init__(self) -> None:
        super().__init__()
        self._props["path"] = STOP_PATH


class SessionGuard(Element, component="session_guard.js"):
    """Ends a page whose session or certificate is over, also while its browser cannot hear of that."""

    def __init__(self, owner: str, expires: float) -> None:
        """Watch.

        Args:
            owner: Of the certificate of the browser; empty without one.
            expires: When that does, s since 1970.
        """
        super().__init__()
        self._props["path"] = SESSION_PATH
        if isfinite(expires):
            self._props["expires"] = expires
            self._props["expired"] = _ended_page(why_expired(owner, expires))

    def end(self, why: str) -> None:
        """Leave the page, and show why, in words."""
        self.run_method("end", _ended_page(why))


def begin_page(console: Console, page: ConsolePage, pages: Sequence[ConsolePage], robot: str = "") -> None:
    """Build one page for one browser, with its frame.

    Args:
        console: The program.
        page: Which.
        pages: All of them.
        robot: Which the page shows; empty for none.
    """
    client = ui.context.client
    cookies = client.request.cookies if client.request is not None else {}
    scope = client.request.scope if client.request is not None else {}
    owner, session = owner_of(scope), cookies.get(COOKIE, "")
    session = "" if owner else session
    visit = console.visits.begin(client.ip or "?", session, why_look_only(scope), owner, expiry_of(scope))
    visit.robot = robot
    client.on_delete(lambda: console.visits.end(visit))
    ui.add_css(STYLE)
    ui.add_css(CONSOLE_STYLE)
    ui.page_title(f"{page.title} · Acromovi")
    ui.colors(primary="#2f6fd0", negative="#c3271b", positive="#1f7a4a")
    theme = cookies.get(_THEME)
    dark = ui.dark_mode({"dark": True, "light": False}.get(theme or ""))
    ui.html('<a class="c-skip" href="#content">Skip to the content</a>', sanitize=False)
    with ui.element("header").classes("c-top"):
        ui.link("Acromovi", "/").classes("c-brand")
        _TeamBar(console, visit)
        with ui.element("div").classes("c-actions"):
            _theme_button(dark)
            if visit.session:
                ui.button(icon="logout", on_click=lambda: _log_out()).props('flat round dense aria-label="Log out"')
            if console.replay is None:
                StopButton()
            if visit.session or visit.owner:
                visit.on_end = partial(_end_page, client, SessionGuard(visit.owner, visit.expires))
    with ui.element("nav").classes("c-nav").props('aria-label="Pages"'):
        for each in pages:
            if each.is_offered(console):
                is_here = each is page
                with ui.link(target=each.path).classes("c-tab" + (" c-here" if is_here else "")) as link:
                    ui.icon(each.icon).props('aria-hidden="true"')
                    ui.label(each.title)
                if is_here:
                    link.props('aria-current="page"')
    if console.replay is not None:
        ReplayBar(console, console.replay)
    with ui.element("div").classes("c-main").props('id="content" tabindex="-1"'):
        page.build(console, visit)


class RobotChips(Element, component="robot_chips.js"):
    """The robots of the team in the top bar."""

    def show(self, rows: list[tuple[str, str, str]], chosen: str) -> None:
        """Show robots: name, state, state in words; and which one is chosen."""
        if (rows, chosen) != (self._props.get("rows"), self._props.get("chosen")):
            self._props["rows"] = rows
            self._props["chosen"] = chosen


class _TeamBar:
    """The robots, and the button that releases their emergency stops."""

    def __init__(self, console: Console, visit: Visit) -> None:
        self._console, self._visit = console, visit
        self._chips = RobotChips()
        with ui.element("div").classes("c-held"):
            self._release = ui.button("Release the stop", icon="lock_open", on_click=self._ask).props(
                "outline dense no-caps color=negative"
            )
        self._refresh()
        ui.timer(_REFRESH, self._refresh)

    def _refresh(self) -> None:
        robots = [self._console.robots.robots[name] for name in self._console.robots.names]
        self._chips.show([(robot.name, *standing(robot)) for robot in robots], self._visit.robot)
        self._release.set_visibility(any(robot.is_stopped for robot in robots) and not self._why_not())

    def _why_not(self) -> str:
        return self._console.why_not(self._visit, keys.ESTOP)

    async def _ask(self) -> None:
        """Ask whether the robots may move again, and release their stops."""
        if self._why_not():
            return
        held = [robot.name for robot in self._console.robots.robots.values() if robot.is_stopped]
        with ui.dialog() as dialog, ui.card().classes("c-dialog"):
            ui.label("Release the emergency stop?").classes("rv-heading")
            ui.label(f"{', '.join(held)} can move again then, and their motors are switched on.")
            with ui.row().classes("rv-row"):
                ui.button("Release", on_click=lambda: dialog.submit(True)).props("no-caps color=negative")
                ui.button("Keep them stopped", on_click=lambda: dialog.submit(False)).props("no-caps flat")
        if await dialog:
            for robot in held:
                if why := await self._console.release_stop(robot):
                    ui.notify(f"{robot}: {why}", type="negative")
                else:
                    self._console.timeline.tell("e-stop", robot, f"the stop was released by {self._visit.name}")
        dialog.delete()


def _theme_button(dark: ui.dark_mode) -> None:
    """A button for light, dark, and the theme of the system."""
    themes = (("light", "light_mode", False), ("dark", "dark_mode", True), ("system", "brightness_auto", None))

    def choose(name: str, value: bool | None) -> None:
        dark.set_value(value)
        button.props(f"icon={next(icon for each, icon, _ in themes if each == name)}")
        ui.run_javascript(f"document.cookie = '{_THEME}={name}; path=/; max-age={_YEAR}; SameSite=Strict'")

    icon = next(icon for _, icon, value in themes if value is dark.value)
    with ui.button(icon=icon).props('flat round dense aria-label="Theme"') as button, ui.menu():
        for name, _, value in themes:
            ui.menu_item(f"{name.capitalize()} theme", lambda name=name, value=value: choose(name, value))


def _ended_page(why: str) -> str:
    """Return the HTML that is shown in the place of a page that has ended."""
    return _ENDED.replace("WORDS", html.escape(f"{why[0].upper()}{why[1:]}."))


def _end_page(client: Client, guard: SessionGuard, why: str) -> None:
    """Leave this page, and take no more orders from it.

    Args:
        client: The page.
        guard: Its guard.
        why: What its browser shows then, in words; empty for the page for the password.
    """
    if why:
        guard.end(why)
    else:
        client.run_javascript("location.assign('/login')")

    def end() -> None:
        if client.has_socket_connection:  # otherwise its browser has left, and NiceGUI deletes it
            client.delete()

    asyncio.get_running_loop().call_later(_PARTING, end)


def _log_out() -> None:
    ui.run_javascript("fetch('/logout', { method: 'POST' }).then(() => location.assign('/login'))")

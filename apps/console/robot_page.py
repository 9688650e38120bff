"""The page Robot: its state, driving it, and a panel for each element that it has."""

from urllib.parse import quote

from nicegui import ui

from apps.console.outcomes import OutcomeList
from apps.console.page import panel
from apps.console.panels.arm import ArmPanel
from apps.console.panels.camera import CameraPanel
from apps.console.panels.drive import DrivePanel
from apps.console.panels.gripper import GripperPanel
from apps.console.panels.outputs import OutputsPanel, PowerPanel, SonarPanel
from apps.console.panels.panel import RobotPanel
from apps.console.panels.sound import SoundPanel
from apps.console.panels.status import StatusPanel
from apps.console.program import Console
from apps.console.visits import Visit

PANELS: tuple[tuple[str, int, type[RobotPanel]], ...] = (
    ("", 0, StatusPanel),
    ("base", 1, DrivePanel),
    ("camera", 2, CameraPanel),
    ("gripper", 1, GripperPanel),
    ("arm", 2, ArmPanel),
    ("sonar", 0, SonarPanel),
    ("sound", 0, SoundPanel),
    ("io", 0, OutputsPanel),
    ("power", 0, PowerPanel),
)
"""Element that a panel needs (none for ""), column, and panel; they appear and disappear with the element."""
_KINDS = {True: ("EMULATED", "c-emulated"), False: ("REAL", "c-real"), None: ("NOT KNOWN YET", "c-quiet")}
_REFRESH = 0.3  # s


def build(console: Console, visit: Visit) -> None:
    """Build the page."""
    _RobotPage(console, visit)


class _RobotPage:
    def __init__(self, console: Console, visit: Visit) -> None:
        self._console, self._visit = console, visit
        self._shown: object = None
        self._panels: list[RobotPanel] = []
        self._box = ui.element("div")
        self._refresh()
        ui.timer(_REFRESH, self._refresh)

    def _refresh(self) -> None:
        if not self._visit.robot and len(self._console.robots.names) == 1:
            ui.navigate.to(f"/robot/{quote(self._console.robots.names[0], safe='')}")
        robot = self._console.robots.robots.get(self._visit.robot)
        if robot is None:
            self._tell_unknown()
            return
        present = set(robot.elements) if robot.description else set()
        shown = tuple(element for element, _, _ in PANELS if element in present or not element)
        if (shown, robot.is_emulated) != self._shown:
            self._shown = shown, robot.is_emulated
            self._build(shown)
        for each in self._panels:
            each.refresh()

    def _build(self, shown: tuple[str, ...]) -> None:
        self._panels = []
        self._box.clear()
        with self._box:
            with ui.element("h1").classes("c-title"):
                ui.label(self._visit.robot)
                words, look = _KINDS[self._console.robots.robots[self._visit.robot].is_emulated]
                ui.label(words).classes(f"c-badge {look}")
                if self._console.replay is not None:
                    ui.label("REPLAY").classes("c-badge c-recorded")
            with ui.element("div").classes("c-columns"):
                for column in range(3):
                    with ui.element("div").classes("c-stack" + (" c-drivers" if column == 1 else "")):
                        for element, where, kind in PANELS:
                            if where == column and element in shown:
                                self._panels.append(kind(self._console, self._visit))
                        if column == 1:
                            with panel("Outcomes"):
                                OutcomeList(self._visit)

    def _tell_unknown(self) -> None:
        names = tuple(self._console.robots.names)
        if self._shown == names:
            return
        self._shown = names
        self._panels = []
        self._box.clear()
        with self._box, panel("Robot"):
            if self._visit.robot:
                ui.label(f"{self._visit.robot} is not on the bus. Its page appears when it comes.")
            elif names:
                ui.label("Choose a robot in the bar above.")
            else:
                ui.label("No robot is on the bus yet; start a team with: acromovi up TEAM")

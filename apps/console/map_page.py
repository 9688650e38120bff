"""The page Map: the team on one map, a robot chosen by a click, and sent to a place by another."""

from math import degrees
from urllib.parse import quote

from nicegui import ui
from nicegui.events import GenericEventArguments, ValueChangeEventArguments

from apps.console.health import standing
from apps.console.locating import BUILT, LOCALIZATION
from apps.console.map_canvas import LAYERS, MapCanvas
from apps.console.map_feed import encoded_goal
from apps.console.outcomes import OutcomeList
from apps.console.page import panel
from apps.console.patrol_panel import PatrolPanel
from apps.console.program import Console
from apps.console.visits import Visit
from geometry import Pose2D

_NAVIGATION = "user_interface"
_REFRESH = 0.3  # s
_LABELS = {
    "walls": "Walls",
    "seen": "What lasers have seen",
    "sonar": "Sonar",
    "laser": "Laser",
    "trails": "Paths driven",
    "missions": "Goals, plans and doors",
    "located": "Localization",
    "goals": "Goals of the map",
    "overlays": "Applications",
    "names": "Names",
}


def build(console: Console, visit: Visit) -> None:
    """Build the page."""
    _MapPage(console, visit)


class _MapPage:
    def __init__(self, console: Console, visit: Visit) -> None:
        self._console, self._visit = console, visit
        with ui.element("div").classes("c-map-page"):
            self._map = MapCanvas(visit, visit.robot)
            self._map.on("choose", self._choose)
            self._map.on("goal", self._send)
            self._map.on("named", lambda event: self._send_to(str(event.args.get("name", ""))))
            self._map.on("relocate", self._relocate)
            with ui.element("div").classes("c-stack c-map-side"):
                with panel("Robot"):
                    self._about = ui.label().props('role="status"')
                    self._mission = ui.label().classes("c-quiet")
                    with ui.row().classes("rv-row"):
                        self._sending = ui.switch("Send by a click", on_change=self._switch)
                        ui.switch("Follow", on_change=lambda event: self._map.follow(event.value))
                    with ui.row().classes("rv-row"):
                        self._cancel = ui.button("Cancel the mission", on_click=self._cancel_mission).props(
                            "outline dense no-caps"
                        )
                        self._link = ui.link("Drive and details", "/robot")
                    self._hint = ui.label().classes("rv-hint")
                with panel("Localization") as self._locating:
                    self._located = ui.label().props('role="status"')
                    with ui.row().classes("rv-row"):
                        self._relocating = ui.switch("Relocalize by a click", on_change=self._switch)
                    with ui.row().classes("rv-row"):
                        self._goal = ui.select([], label="Goal of the map").props("dense").classes("rv-name")
                        self._go = ui.button("Go there", on_click=lambda: self._send_to(str(self._goal.value or "")))
                        self._go.props("outline dense no-caps")
                    ui.label("Click where the robot is; drag to where it looks.").classes("rv-hint")
                self._patrol = PatrolPanel(console)
                with panel("Layers"), ui.element("div").classes("c-checks"):
                    self._layers = {
                        name: ui.checkbox(_LABELS[name], value=True, on_change=self._show).props("dense")
                        for name in LAYERS
                    }
                with panel("Outcomes"):
                    OutcomeList(visit)
        self._refresh()
        ui.timer(_REFRESH, self._refresh)

    def _refresh(self) -> None:
        robot = self._console.robots.robots.get(self._visit.robot)
        self._link.set_visibility(robot is not None)
        self._show_locating()
        self._patrol.refresh()
        self._cancel.set_visibility(False)
        if robot is None:
            self._about.text = "No robot is chosen: click one on the map, or press n on it."
            self._mission.text = self._hint.text = ""
            self._sending.set_enabled(False)
            return
        self._about.text = f"{robot.name}: {standing(robot)[1]}"
        if (pose := robot.pose) is not None:
            self._about.text += f", x {pose[0]:.2f} m, y {pose[1]:.2f} m in its odom"
        self._link.props(f'href="/robot/{quote(robot.name, safe="")}"')
        mission = self._console.map.missions.get(robot.name)
        self._mission.text = ""
        if mission and mission["mission"]:
            self._mission.text = f"{mission['mission']}: {mission['state']}" + (
                f" ({mission['why']})" if mission["why"] else ""
            )
            self._cancel.set_visibility(bool(mission["goal"]) and self._visit.may_command)
        why = self._why_not_sent()
        self._sending.set_enabled(not why)
        if why and self._sending.value:
            self._sending.value = False
        self._hint.text = why or "Click the floor to send it there; drag to set the heading at the goal as well."

    def _why_not_sent(self) -> str:
        """Return why the chosen robot cannot be sent; empty if it can."""
        if why := self._visit.look_only:
            return why
        robot = self._visit.robot
        if not any(name.local == _NAVIGATION and name.platform == robot for name in self._console.directory.names):
            return f"nobody navigates {robot}; start it with: acromovi navigate up {robot}"
        return ""

    def _show_locating(self) -> None:
        """Show how the chosen robot is localized, and the goals of its map."""
        robot = self._visit.robot
        located = self._console.map.locating.located.get(robot)
        self._locating.set_visibility(located is not None)
        if located is None:
            self._relocating.value = False
            return
        words, deviations = located["state"], located["deviations"]
        if deviations is not None:
            words += f", ±{2 * max(deviations[:2]):.2f} m, ±{2 * degrees(deviations[2]):.0f}°"
        self._located.text = f"{robot}: {words}" + (f"; {located['reason']}" if located["reason"] else "")
        is_map = located["map"] != BUILT
        self._relocating.set_enabled(self._visit.may_command and is_map)
        names = [goal["name"] for goal in self._console.map.goals.get(robot, ())]
        if names != self._goal.options:
            self._goal.set_options(names, value=self._goal.value if self._goal.value in names else None)
        self._goal.set_visibility(bool(names))
        self._go.set_visibility(bool(names))
        self._go.set_enabled(self._goal.value is not None and not self._why_not_sent())

    async def _relocate(self, event: GenericEventArguments) -> None:
        """Tell the localization where the chosen robot is."""
        robot, told = self._visit.robot, event.args
        if told.get("robot") != robot or not self._visit.may_command:
            return
        located = self._console.map.locating.located.get(robot)
        if located is None:
            return
        heading = told.get("heading")
        if heading is None:  # as it is shown now
            heading = located["pose"][2] if located["pose"] is not None else 0.0
        there = Pose2D(told["x"], told["y"], heading).relative_to(self._console.map.places.map_of(robot))
        pose = {"x": round(there.x, 3), "y": round(there.y, 3), "heading": round(there.heading, 4)}
        outcome = await self._console.ask(f"{LOCALIZATION}@{robot}", "set_pose", **pose)
        words = "begins again there" if outcome.is_done else f"does not: {outcome.why}"
        self._console.say(self._visit, f"the localization of {robot} {words}")
        self._relocating.value = False

    async def _send_to(self, name: str) -> None:
        """Send the chosen robot to a goal of the map."""
        robot = self._visit.robot
        if not name or self._why_not_sent():
            return
        goal = await self._console.ask(f"{LOCALIZATION}@{robot}", "goal", place=name)
        if not goal.is_done or not isinstance(goal.result, dict):
            self._console.say(self._visit, f"{robot} was not sent to {name}: {goal.why}")
            return
        given = {key: value for key, value in goal.result.items() if key in ("x", "y", "heading") and value is not None}
        outcome = await self._console.ask(f"{_NAVIGATION}@{robot}", "go", **given)
        words = f"{robot} is sent to {name}" if outcome.is_done else f"{robot} was not sent to {name}: {outcome.why}"
        self._console.say(self._visit, words)

    def _choose(self, event: GenericEventArguments) -> None:
        robot = str(event.args.get("robot", ""))
        if robot and robot not in self._console.robots.robots:
            return
        self._visit.robot = self._map.chosen = robot
        self._refresh()

    def _switch(self, event: ValueChangeEventArguments[bool | None]) -> None:
        """Let the pointer send or relocalize the robot, one of them at most."""
        if event.value:
            (self._relocating if event.sender is self._sending else self._sending).value = False
        self._map.mode = "send" if self._sending.value else "relocate" if self._relocating.value else "look"

    def _show(self) -> None:
        self._map.show([name for name, box in self._layers.items() if box.value])

    async def _send(self, event: GenericEventArguments) -> None:
        robot, told = self._visit.robot, event.args
        if self._why_not_sent() or told.get("robot") != robot:
            return
        goal = encoded_goal(self._console.map.places.of(robot), told["x"], told["y"], told.get("heading"))
        outcome = await self._console.ask(f"{_NAVIGATION}@{robot}", "go", **goal)
        where = f"x {told['x']:.2f} m, y {told['y']:.2f} m on the map"
        words = f"{robot} is sent to {where}" if outcome.is_done else f"{robot} was not sent: {outcome.why}"
        self._console.say(self._visit, words)

    async def _cancel_mission(self) -> None:
        if not self._visit.may_command:
            return
        outcome = await self._console.ask(f"{_NAVIGATION}@{self._visit.robot}", "cancel")
        words = "the mission is cancelled" if outcome.is_done else f"the mission goes on: {outcome.why}"
        self._console.say(self._visit, f"{self._visit.robot}: {words}")

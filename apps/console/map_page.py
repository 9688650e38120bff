"""The page Map: the team on one map, a robot chosen by a click, and sent to a place by another."""

from urllib.parse import quote

from nicegui import ui
from nicegui.events import GenericEventArguments

from apps.console.health import standing
from apps.console.map_canvas import LAYERS, MapCanvas
from apps.console.map_feed import encoded_goal
from apps.console.outcomes import OutcomeList
from apps.console.page import panel
from apps.console.program import Console
from apps.console.visits import Visit

_NAVIGATION = "user_interface"
_REFRESH = 0.3  # s
_LABELS = {
    "walls": "Walls",
    "seen": "What lasers have seen",
    "sonar": "Sonar",
    "laser": "Laser",
    "trails": "Paths driven",
    "missions": "Goals, plans and doors",
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
            self._cancel.set_visibility(bool(mission["goal"]) and self._console.may_command)
        why = self._why_not_sent()
        self._sending.set_enabled(not why)
        if why and self._sending.value:
            self._sending.value = False
        self._hint.text = why or "Click the floor to send it there; drag to set the heading at the goal as well."

    def _why_not_sent(self) -> str:
        """Return why the chosen robot cannot be sent; empty if it can."""
        if why := self._console.look_only:
            return why
        robot = self._visit.robot
        if not any(name.local == _NAVIGATION and name.platform == robot for name in self._console.directory.names):
            return f"nobody navigates {robot}; start it with: acromovi navigate up {robot}"
        return ""

    def _choose(self, event: GenericEventArguments) -> None:
        robot = str(event.args.get("robot", ""))
        if robot and robot not in self._console.robots.robots:
            return
        self._visit.robot = self._map.chosen = robot
        self._refresh()

    def _switch(self) -> None:
        self._map.mode = "send" if self._sending.value else "look"

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
        outcome = await self._console.ask(f"{_NAVIGATION}@{self._visit.robot}", "cancel")
        words = "the mission is cancelled" if outcome.is_done else f"the mission goes on: {outcome.why}"
        self._console.say(self._visit, f"{self._visit.robot}: {words}")

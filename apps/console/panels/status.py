"""The panel of a robot's state: what it is, how it is, and who holds it."""

from math import isfinite

from nicegui import ui

from apps.console.health import low_battery, warnings
from apps.console.page import panel
from apps.console.program import Console
from apps.console.robots import WatchedRobot
from apps.console.visits import Visit
from bus import keys


class StatusPanel:
    """The state of a robot, and the switches of its motors and its emergency stop."""

    def __init__(self, console: Console, visit: Visit) -> None:
        """Build it."""
        self._console, self._visit = console, visit
        self._facts: dict[str, ui.label] = {}
        self._shown: list[str] | None = None
        with panel("State"):
            self._model = ui.label().classes("c-quiet")
            with ui.element("dl").classes("c-facts"):
                for name in _facts(console.robots.robots[visit.robot], console.robots.clock()):
                    with ui.element("dt"):
                        ui.label(name)
                    with ui.element("dd"):
                        self._facts[name] = ui.label()
            with ui.row().classes("rv-row"):
                self._motors = ui.button(on_click=self._switch_motors).props("outline dense no-caps")
                self._halt = ui.button("Stop this robot", on_click=self._stop).props("outline dense no-caps")
                self._free = ui.button("Release its e-stop", on_click=self._release).props(
                    "outline dense no-caps color=negative"
                )
            self._warnings = ui.element("ul").classes("c-warnings").props('aria-label="Warnings" aria-live="polite"')

    def refresh(self) -> None:
        """Show the newest readings."""
        robot = self._console.robots.robots[self._visit.robot]
        self._show_model(robot)
        for name, words in _facts(robot, self._console.robots.clock()).items():
            self._facts[name].text = words
        state = robot.state
        may = self._visit.may_command and robot.is_connected
        self._motors.text = "Switch the motors off" if state is not None and state.motors else "Switch the motors on"
        self._motors.set_enabled(may and not robot.is_stopped)
        self._halt.set_enabled(may)
        self._free.set_visibility(robot.is_stopped)
        self._free.set_enabled(may)
        found = warnings(robot)
        if found != self._shown:
            self._shown = found
            self._warnings.clear()
            with self._warnings:
                for each in found:
                    with ui.element("li"):
                        ui.label(each)

    def _show_model(self, robot: WatchedRobot) -> None:
        versions = robot.description.get("versions")
        firmware = versions.get("firmware", "") if isinstance(versions, dict) else ""
        self._model.text = f"{robot.description.get('model', 'model not known')}, {firmware}".rstrip(", ")

    async def _switch_motors(self) -> None:
        robot = self._console.robots.robots[self._visit.robot]
        on = not (robot.state is not None and robot.state.motors)
        why = await self._console.enable(robot.name, on=on)
        self._console.say(self._visit, f"{robot.name}: {why or ('motors on' if on else 'motors off')}")

    async def _stop(self) -> None:
        why = await self._console.command(self._visit.robot, keys.STOP)
        self._console.say(self._visit, f"{self._visit.robot}: {why or 'stopped'}")

    async def _release(self) -> None:
        why = await self._console.release_stop(self._visit.robot)
        self._console.say(self._visit, f"{self._visit.robot}: {why or 'the e-stop is released, the motors are on'}")


def _facts(robot: WatchedRobot, now: float) -> dict[str, str]:
    """Return what is shown of a robot at a time, s, in words."""
    state = robot.state
    odom = robot.newest(keys.ODOM)
    twist = odom.twist.twist if odom is not None else None
    holder = robot.holder()
    return {
        "Connection": state.connection if state is not None else "not known",
        "Motors": "-" if state is None else "on" if state.motors else "off",
        "E-stop": "-" if state is None else "holds the robot" if state.estop else "free",
        "Battery": _battery(robot),
        "Wheels": _wheels(robot),
        "Bumpers": _bumpers(robot),
        "Line": _line(robot, now),
        "Lease": f"{holder} has it" if holder else "nobody has it",
        "Speed": f"{twist.linear.x:+.2f} m/s, {twist.angular.z:+.2f} rad/s" if twist is not None else "-",
    }


def _battery(robot: WatchedRobot) -> str:
    battery = robot.newest(keys.BATTERY)
    if battery is None or not isfinite(battery.voltage):
        return "-"
    words = f"{battery.voltage:.1f} V"
    if isfinite(battery.percentage):
        words += f", {battery.percentage:.0%}"
    if (low := low_battery(robot)) is not None:
        words += f" (low below {low:.1f} V)"
    return words


def _wheels(robot: WatchedRobot) -> str:
    flags = robot.newest(keys.BUMPERS)
    if flags is None:
        return "-"
    stalled = [side for side, is_so in (("left", flags.stall_left), ("right", flags.stall_right)) if is_so]
    return f"stalled: {' and '.join(stalled)}" if stalled else "not stalled"


def _bumpers(robot: WatchedRobot) -> str:
    flags = robot.newest(keys.BUMPERS)
    if flags is None or not (len(flags.front) or len(flags.rear)):
        return "none"
    pressed = [
        f"{where} {number + 1}"
        for where, row in (("front", flags.front), ("rear", flags.rear))
        for number, is_pressed in enumerate(row)
        if is_pressed
    ]
    return f"pressed: {', '.join(pressed)}" if pressed else "free"


def _line(robot: WatchedRobot, now: float) -> str:
    odom, diagnostics = robot.readings.get(keys.ODOM.suffix), robot.newest(keys.DIAGNOSTICS)
    words = []
    if odom is not None:
        cycle = robot.description.get("sip_cycle")
        wanted = f" of {1.0 / cycle:.0f}" if isinstance(cycle, int | float) and cycle > 0 else ""
        words.append(f"{odom.rate(now):.0f}{wanted} Hz")
    for status in diagnostics.status if diagnostics is not None else ():
        if status.name.endswith(": cable"):
            words.append(status.message)
            words += [f"{row.value} bit/s" for row in status.values if row.key == "baud"]
    return ", ".join(words) or "-"

"""What a robot's state means, in words: for the top bar, and as advice in the words of `acromovi doctor`."""

from math import isfinite

from apps.console.robots import WatchedRobot
from bus import keys

NOT_CONNECTED = "the robot is not connected"
LATCHED = "the e-stop is latched"


def standing(robot: WatchedRobot) -> tuple[str, str]:
    """Return the state of a robot: `ok`, `warning`, `alarm` or `away`, and in one or two words."""
    state = robot.state
    if not robot.is_there:
        return "away", "away"
    if state is None:
        return "away", "no state yet"
    if state.connection != "connected":
        return "warning", str(state.connection)
    if state.estop:
        return "alarm", "E-STOP"
    if not state.motors:
        return "warning", "motors off"
    if warnings(robot):
        return "warning", "warning"
    return "ok", "driving" if _moves(robot) else "ready"


def warnings(robot: WatchedRobot) -> list[str]:
    """Return what is wrong with a robot and what to do, a sentence each; empty if all is well."""
    state = robot.state
    if not robot.is_there:
        return [f"{robot.name} is not on the bus: its gateway does not run; start it with: acromovi up TEAM"]
    if state is None:
        return ["the robot has not reported its state yet"]
    found = [fault for fault in state.faults if fault not in (NOT_CONNECTED, LATCHED)]
    if state.connection != "connected":
        found.insert(0, f"the gateway is not connected to the robot ({state.connection})")
    battery, low = robot.newest(keys.BATTERY), low_battery(robot)
    if battery is not None and low is not None and isfinite(battery.voltage) and 0.0 < battery.voltage < low:
        found.append(f"battery: {battery.voltage:.1f} V; charge it; {low:.1f} V is low for this robot")
    if (diagnostics := robot.newest(keys.DIAGNOSTICS)) is not None:
        for status in diagnostics.status:
            if status.level > 0 and status.message not in found and not any(fault in status.message for fault in found):
                found.append(f"{status.name.partition(': ')[2]}: {status.message}")
    return found


def low_battery(robot: WatchedRobot) -> float | None:
    """Return the voltage from which down a robot's battery is low, V; None if it is not known."""
    battery = robot.description.get("battery")
    low = battery.get("low") if isinstance(battery, dict) else None
    return float(low) if isinstance(low, int | float) else None


def _moves(robot: WatchedRobot) -> bool:
    odom = robot.newest(keys.ODOM)
    twist = odom.twist.twist if odom is not None else None
    return twist is not None and (abs(twist.linear.x) > 0.01 or abs(twist.angular.z) > 0.02)

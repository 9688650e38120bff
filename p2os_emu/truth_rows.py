"""What the control socket tells as the truth: how robots, things, people and doors really are. SI and radians."""

from typing import Any

from p2os_emu.emulator import EmulatedRobot, Emulator
from p2os_emu.microcontroller import Microcontroller

LAST_TOUCHES = 10
"""Of a robot, in one answer; the count has them all."""


def surroundings_rows(emulator: Emulator) -> dict[str, Any]:
    """Where things are, and people and doors that move."""
    people = {
        name: {"x": x, "y": y, "heading": heading, "walks": walks}
        for name, (x, y, heading, walks) in emulator.people().items()
    }
    doors = {name: {"opening": opening, "width": width} for name, (opening, width) in emulator.doors().items()}
    return {"objects": emulator.objects(), "people": people, "doors": doors}


def robot_row(emulator: Emulator, robot: EmulatedRobot) -> dict[str, Any]:
    """How one robot is: its truth, its board and its line."""
    truth = emulator.truth(robot.name)
    touches = emulator.touches(robot.name)
    return {
        "x": truth.pose.x,
        "y": truth.pose.y,
        "heading": truth.pose.heading,
        "linear": truth.linear,
        "angular": truth.angular,
        "model": robot.model.name,
        "port": robot.line.link.port,
        "connected": robot.microcontroller.connected,
        "motors_enabled": robot.microcontroller.motors_enabled,
        "battery_charge": robot.microcontroller.battery_charge,
        "frames_dropped": robot.line.link.dropped,
        "touches": touches.count,
        "touched": [{"time": time, "what": what} for time, what in touches.last[-LAST_TOUCHES:]],
        **_shown(robot.microcontroller),
    }


def _shown(controller: Microcontroller) -> dict[str, Any]:
    """What people would see and hear of the board."""
    outputs = controller.outputs
    return {
        "notes": [note._asdict() for note in controller.notes],
        "lcd": outputs.lcd,
        "servos": {str(port): pulse for port, pulse in outputs.servos.items()},
        "power": dict(outputs.power),
        "digital_out": controller.digital_out,
        "charging": controller.charging.name.lower(),
        "shutdown_wanted": controller.shutdown_wanted,
        "simulator_messages": list(controller.simulator_messages),
    }

"""The page Vision: remote vision, with its operations and colour channels, for the cameras of the team."""

from nicegui import ui

from apps.console.page import panel
from apps.console.program import Console
from apps.console.visits import Visit
from apps.remote_vision.cameras import CAMERA
from apps.remote_vision.view import VisionView

_PROGRAM = "acromovi console"


def is_offered(console: Console) -> bool:
    """Return whether a robot has had a camera, and what aims one is installed."""
    return console.can_aim and console.replay is None and bool(console.vision.team.facts)


def build(console: Console, visit: Visit) -> None:
    """Build the page, with the camera of the robot of the page or the first one that there is."""
    vision = console.vision
    robots = sorted(vision.team.facts)
    if not robots:
        with panel("Vision"):
            ui.label("No robot with a camera is on the bus yet; load the page again when one is there.")
        return
    there = [robot for robot in robots if vision.team.has(robot, CAMERA)]
    robot = visit.robot or (there or robots)[0]
    viewing = vision.begin_viewing(robot, visit.name)
    ui.context.client.on_delete(lambda: vision.end_viewing(viewing))
    VisionView(vision, viewing, _PROGRAM, look_only=visit.look_only)

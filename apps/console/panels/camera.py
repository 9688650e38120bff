"""The panel of a camera and its head: the viewer of remote vision, in the page of a robot."""

from urllib.parse import quote

from nicegui import ui

from apps.console.page import panel
from apps.console.program import Console
from apps.console.vision_page import is_offered
from apps.console.visits import Visit
from apps.remote_vision.head_panel import HeadPanel
from apps.remote_vision.viewing import ORIGINAL
from apps.web.viewer import ImageViewer

_PROGRAM = "acromovi console"


class CameraPanel:
    """The image of a camera; the browser requests the next one after it has drawn the last."""

    def __init__(self, console: Console, visit: Visit) -> None:
        """Build it."""
        vision = console.vision
        self._viewing = viewing = vision.begin_viewing(visit.robot, visit.name)
        ui.context.client.on_delete(lambda: vision.end_viewing(viewing))
        with panel("Camera"):
            old = vision.settings.images.old_s
            image = ImageViewer(f"/images/{viewing.ticket}/{ORIGINAL}", visit.robot, old, _PROGRAM, "steer")
            if is_offered(console):
                ui.link("Operations, colours and results", f"/vision/{quote(visit.robot, safe='')}").classes("rv-hint")
        self._head = HeadPanel(vision, viewing, image) if visit.may_command and console.can_aim else None

    def refresh(self) -> None:
        """Show who steers the head."""
        if self._head is not None:
            self._head.refresh()

"""The page: a live image."""

from nicegui import ui

from apps.remote_vision.program import RemoteVision
from apps.remote_vision.viewer import ImageViewer
from apps.remote_vision.viewing import ORIGINAL


def build_page(program: RemoteVision, robot: str) -> None:
    """Register the page."""

    @ui.page("/")
    def page() -> None:
        viewing = program.begin_viewing(robot, "?")
        ImageViewer(f"/images/{viewing.ticket}/{ORIGINAL}", robot, program.settings.images.old_s, "steer")

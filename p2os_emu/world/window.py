"""The window on a world: `p2os-emu --gui`."""

import os
from collections.abc import Mapping

from p2os_emu.world.engine import PhysicsClient, engine
from p2os_emu.world.errors import WorldError
from p2os_emu.world.look import Look
from p2os_emu.world.spec import WorldSpec

PITCH_DEG = -60.0
LEAST_DISTANCE = 6.0  # m from the camera to what it looks at
ROOM = 0.75  # distance per metre that the world is wide

_PANELS = ("COV_ENABLE_GUI", "COV_ENABLE_RGB_BUFFER_PREVIEW", "COV_ENABLE_DEPTH_BUFFER_PREVIEW")
_EFFECTS = ("COV_ENABLE_SEGMENTATION_MARK_PREVIEW", "COV_ENABLE_SHADOWS", "COV_ENABLE_KEYBOARD_SHORTCUTS")


def connect() -> int:
    """Open a window; returns the engine's client, below zero when it cannot.

    Raises:
        WorldError: There is no display.
    """
    if not os.environ.get("DISPLAY"):
        raise WorldError("there is no display for a window: leave out --gui, or set DISPLAY to a running X server")
    client: int = engine.connect(engine.GUI)
    return client


def arrange(client: PhysicsClient, spec: WorldSpec) -> None:
    """Show the whole world from above at a slant, without the engine's own panels."""
    for name in (*_PANELS, *_EFFECTS):
        client.configureDebugVisualizer(getattr(engine, name), 0)
    x, y, extent = spec.middle
    client.resetDebugVisualizerCamera(
        cameraDistance=max(LEAST_DISTANCE, ROOM * extent),
        cameraYaw=0.0,
        cameraPitch=PITCH_DEG,
        cameraTargetPosition=[x, y, 0.0],
    )


def paint(client: PhysicsClient, body: int, looks: Mapping[int, Look]) -> None:
    """Give a body's links the colours of their looks."""
    for link, look in looks.items():
        client.changeVisualShape(body, link, rgbaColor=look[0].colour)

"""The window on a world: `p2os-emu --gui`."""

import os
from collections.abc import Iterable

from p2os_emu.world.engine import engine
from p2os_emu.world.errors import WorldError
from p2os_emu.world.spec import Block, WorldSpec

Colour = tuple[float, float, float, float]

WALL_COLOUR: Colour = (0.86, 0.85, 0.82, 1.0)
FURNITURE_COLOUR: Colour = (0.62, 0.48, 0.34, 1.0)
ROBOT_COLOUR: Colour = (0.72, 0.10, 0.12, 1.0)
WHEEL_COLOUR: Colour = (0.12, 0.12, 0.12, 1.0)
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


def arrange(client: int, spec: WorldSpec) -> None:
    """Show the whole world from above at a slant, without the engine's own panels."""
    for name in (*_PANELS, *_EFFECTS):
        engine.configureDebugVisualizer(getattr(engine, name), 0, physicsClientId=client)
    x, y, extent = _middle(spec)
    engine.resetDebugVisualizerCamera(
        cameraDistance=max(LEAST_DISTANCE, ROOM * extent),
        cameraYaw=0.0,
        cameraPitch=PITCH_DEG,
        cameraTargetPosition=[x, y, 0.0],
        physicsClientId=client,
    )


def paint(client: int, bodies: Iterable[int], colour: Colour) -> None:
    """Give bodies and their hulls a colour."""
    for body in bodies:
        engine.changeVisualShape(body, -1, rgbaColor=colour, physicsClientId=client)


def paint_robot(client: int, body: int) -> None:
    """Give a robot the colours that these robots have."""
    paint(client, [body], ROBOT_COLOUR)
    for wheel in range(engine.getNumJoints(body, physicsClientId=client)):
        engine.changeVisualShape(body, wheel, rgbaColor=WHEEL_COLOUR, physicsClientId=client)


def _middle(spec: WorldSpec) -> tuple[float, float, float]:
    """Centre and greatest extent of what stands in a world, m; its first start where nothing does."""
    blocks: tuple[Block, ...] = (*spec.walls, *spec.furniture)
    corners = [corner for block in blocks for corner in block.footprint]
    if not corners:
        return spec.starts[0].x, spec.starts[0].y, 0.0
    xs, ys = [x for x, _ in corners], [y for _, y in corners]
    return (min(xs) + max(xs)) / 2, (min(ys) + max(ys)) / 2, max(max(xs) - min(xs), max(ys) - min(ys))

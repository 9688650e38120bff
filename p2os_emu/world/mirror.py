"""A second world that has looks only, to be drawn from: it hears of the first one's news and knows no physics.

The engine's own renderer needs no graphics at all. Where the machine has some, the engine's plug-in for EGL draws
faster; it ends the whole process where it fails, so it is tried in a process of its own first.
"""

import os
import tempfile
from collections.abc import Iterable
from enum import Enum
from importlib.util import find_spec
from math import atan, degrees, tan
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from p2os_emu.world.engine import PhysicsClient, engine
from p2os_emu.world.floor import PERIOD, Floor, picture
from p2os_emu.world.light import DIRECTION, LightState
from p2os_emu.world.look import Form, ShapePart, Triple
from p2os_emu.world.sight import Placed, SceneChanges
from p2os_emu.world.textures import EDGE, SurfaceTexture, paint
from p2os_emu.world.view import View

NEAR, FAR = 0.05, 60.0
"""m; nearer and farther than this nothing is drawn."""
SKY = (186, 208, 226)
"""Red, green, blue of where there is nothing."""
LIGHT = {"lightAmbientCoeff": 0.6, "lightDiffuseCoeff": 0.35, "lightSpecularCoeff": 0.05}
"""Strengths of light whose brightness is 1: the engine's own."""
GRAPHICS = (Path("/dev/dri"), Path("/dev/nvidia0"))
"""What a machine has one of that has graphics."""
EGL = "eglRenderer"


class _Renderer(Enum):
    """What draws."""

    SOFTWARE = engine.ER_TINY_RENDERER
    HARDWARE = engine.ER_BULLET_HARDWARE_OPENGL


def choose_renderer() -> _Renderer:
    """Return the renderer of this machine: hardware where it is present and works."""
    if not any(device.exists() for device in GRAPHICS) or find_spec(EGL) is None:
        return _Renderer.SOFTWARE
    child = os.fork()
    if child == 0:  # whatever happens here, the parent goes on
        os._exit(0 if _draws_with_hardware() else 1)
    _, status = os.waitpid(child, 0)
    return _Renderer.HARDWARE if status == 0 else _Renderer.SOFTWARE


def _draws_with_hardware() -> bool:
    mirror = Mirror(_Renderer.HARDWARE)
    cube = (ShapePart(Form.BOX, (1.0, 1.0, 1.0), (1.0, 0.0, 0.0, 1.0)),)
    mirror.apply(SceneChanges({0: (cube, Placed((2.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)))}))
    drawn = mirror.draw(View(0.0, 0.0, 0.0, 0.0, 0.0, 1.0), 32, 24)
    return bool(drawn[12, 16, 0] > drawn[12, 16, 1])


class Mirror:
    """Things by their numbers, each part a body without mass."""

    def __init__(self, renderer: _Renderer = _Renderer.SOFTWARE) -> None:
        self._renderer = renderer
        self._client = PhysicsClient(engine.connect(engine.DIRECT))
        self._things: dict[int, list[tuple[int, ShapePart]]] = {}
        self._textures: dict[SurfaceTexture, int] = {}
        self._light: LightState | None = None
        if renderer is _Renderer.HARDWARE:
            plugin = find_spec(EGL)
            assert plugin is not None  # or it would not have been chosen
            self._client.loadPlugin(plugin.origin, f"_{EGL}Plugin")

    def close(self) -> None:
        """Forget everything."""
        self._client.disconnect()

    def apply(self, news: SceneChanges) -> None:
        """Apply the changes."""
        self._light = news.light
        for number in news.gone:
            for body, _ in self._things.pop(number, ()):
                self._client.removeBody(body)
        for number, (look, placed) in news.new.items():
            self._things[number] = [(self._build(part), part) for part in look]
            self._place(self._things[number], placed)
        for number, placed in news.moved.items():
            self._place(self._things.get(number, ()), placed)

    def draw(self, view: View, width: int, height: int) -> NDArray[np.uint8]:
        """Draw a view: rows of pixels with red, green, blue."""
        aspect = width / height
        vertical = 2 * atan(tan(view.field_of_view / 2) / aspect)
        drawn = self._client.getCameraImage(
            width,
            height,
            engine.computeViewMatrix(view.eye, view.ahead, view.up),
            engine.computeProjectionMatrixFOV(degrees(vertical), aspect, NEAR, FAR),
            shadow=0,
            renderer=self._renderer.value,
            flags=engine.ER_NO_SEGMENTATION_MASK,
            **self._lighting(),
        )
        colours = np.reshape(np.asarray(drawn[2], np.uint8), (height, width, 4))[:, :, :3].copy()
        colours[np.reshape(drawn[3], (height, width)) >= 1.0] = self._sky()
        return colours

    def _lighting(self) -> dict[str, Any]:
        """The engine's arguments for the light of now."""
        if self._light is None:
            return {"lightDirection": DIRECTION}
        brightness, direction = self._light
        return {"lightDirection": direction} | {name: strength * brightness for name, strength in LIGHT.items()}

    def _sky(self) -> tuple[int, int, int]:
        brightness = 1.0 if self._light is None else min(1.0, self._light.brightness)
        red, green, blue = (round(part * brightness) for part in SKY)
        return red, green, blue

    def _build(self, part: ShapePart) -> int:
        if part.floor is not None:
            return self._lay(part.floor, part.size)
        if part.texture is not None:
            return self._cover(part.texture, part.size)
        x, y, z = part.size
        match part.form:
            case Form.BOX:
                shape = {"shapeType": engine.GEOM_BOX, "halfExtents": (x / 2, y / 2, z / 2)}
            case Form.CYLINDER:
                shape = {"shapeType": engine.GEOM_CYLINDER, "radius": x / 2, "length": z}
            case Form.SPHERE:
                shape = {"shapeType": engine.GEOM_SPHERE, "radius": x / 2}
        visual = self._client.createVisualShape(rgbaColor=part.colour, **shape)
        body: int = self._client.createMultiBody(0.0, -1, visual)
        return body

    def _lay(self, floor: Floor, size: Triple) -> int:
        """Build the top of a floor, and repeat its pattern over it.

        A picture of the whole floor would take four times its size in memory, 50 MB where a pixel is 14 mm.
        """
        x, y, z = (edge / 2 for edge in size)
        corners = ((-x, -y), (x, -y), (x, y), (-x, y))
        picture_edge = floor.pattern_m * PERIOD
        visual = self._client.createVisualShape(
            engine.GEOM_MESH,
            vertices=[(*corner, z) for corner in corners],
            indices=[0, 1, 2, 0, 2, 3],
            uvs=[((east + x) / picture_edge, (north + y) / picture_edge) for east, north in corners],
            normals=[(0.0, 0.0, 1.0)] * len(corners),
        )
        body: int = self._client.createMultiBody(0.0, -1, visual)
        self._client.changeVisualShape(body, -1, textureUniqueId=self._load(picture(floor)))
        return body

    def _cover(self, texture: SurfaceTexture, size: Triple) -> int:
        """Build a box with a texture on its sides and its top, upright on the sides and in its own size on all."""
        vertices, normals, uvs = [], [], []
        x, y, z = (edge / 2 for edge in size)
        sides = (((x, -y), (x, y)), ((x, y), (-x, y)), ((-x, y), (-x, -y)), ((-x, -y), (x, -y)))
        for (x1, y1), (x2, y2) in sides:
            length = abs(x2 - x1) + abs(y2 - y1)
            vertices += [(x1, y1, -z), (x2, y2, -z), (x2, y2, z), (x1, y1, z)]
            normals += [((y2 - y1) / length, (x1 - x2) / length, 0.0)] * 4
            uvs += [(0.0, 0.0), (length, 0.0), (length, 2 * z), (0.0, 2 * z)]
        vertices += [(-x, -y, z), (x, -y, z), (x, y, z), (-x, y, z)]
        normals += [(0.0, 0.0, 1.0)] * 4
        uvs += [(0.0, 0.0), (2 * x, 0.0), (2 * x, 2 * y), (0.0, 2 * y)]
        visual = self._client.createVisualShape(
            engine.GEOM_MESH,
            vertices=vertices,
            indices=[first + corner for first in range(0, len(vertices), 4) for corner in (0, 1, 2, 0, 2, 3)],
            uvs=[((along + texture.shift) / EDGE, up / EDGE) for along, up in uvs],
            normals=normals,
        )
        body: int = self._client.createMultiBody(0.0, -1, visual)
        same = texture._replace(shift=0.0)
        if same not in self._textures:
            self._textures[same] = self._load(paint(same))
        self._client.changeVisualShape(body, -1, textureUniqueId=self._textures[same])
        return body

    def _load(self, colours: NDArray[np.uint8]) -> int:
        """Give a picture to the engine, which takes them from files only."""
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "texture.bmp"
            Image.fromarray(colours).save(file)
            texture: int = self._client.loadTexture(str(file))
        return texture

    def _place(self, parts: Iterable[tuple[int, ShapePart]], placed: Placed) -> None:
        for body, part in parts:
            place, turn = engine.multiplyTransforms(placed.place, placed.turn, part.place, part.turn)
            self._client.resetBasePositionAndOrientation(body, place, turn)

"""Every scene, by name, in the order in which they are listed."""

from collections.abc import Mapping

from acromovi.scenes import sensors
from acromovi.scenes.stage import Scene

SCENES: Mapping[str, Scene] = {scene.name: scene for scene in sensors.SCENES}

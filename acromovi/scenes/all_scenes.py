"""Every scene, by name, in the order in which they are listed."""

from collections.abc import Mapping

from acromovi.scenes import actuators, faults, lines, recordings, sensors
from acromovi.scenes.stage import Scene

SCENES: Mapping[str, Scene] = {
    scene.name: scene
    for scene in (*actuators.SCENES, *sensors.SCENES, *lines.SCENES, *faults.SCENES, *recordings.SCENES)
}

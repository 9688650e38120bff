"""Watch what is in the way, and say what is free."""

from dataclasses import dataclass, replace
from math import inf

from apps.indoor_navigation.algorithms.obstacle_detection import DetectionParameters, obstacles
from apps.indoor_navigation.algorithms.perception import Perception, PerceptionParameters
from apps.indoor_navigation.component import Role, hears
from apps.indoor_navigation.components.embodied import Embodied
from apps.indoor_navigation.data import LaserRead, ObstRead, SonarRead


@dataclass(frozen=True, slots=True)
class _DetectingParameters:
    """What it believes and what it calls an obstacle.

    sonar_alone: s after the last scan, from which on it says something with each reading of the sonar. dead_end_after:
    readings one after the other that find no way on, before it says so.
    """

    sonar_alone: float
    dead_end_after: int
    senses: PerceptionParameters
    detection: DetectionParameters


class ObstacleDetecting(Embodied):
    """Says with each scan, or without scans with each reading of the sonar, what both see."""

    role = Role.MONITOR
    gives = (ObstRead,)
    parameters_type = _DetectingParameters

    async def setup(self) -> None:
        """Know nothing yet."""
        self._perception = Perception(self.parameters.senses)
        self._scanned_at = -inf
        self._dead_ends = 0
        self._said: tuple[str, ...] = ()
        await super().setup()

    @hears(LaserRead)
    async def look(self, scan: LaserRead) -> None:
        """The laser has seen something."""
        self._perception.take(scan)
        self._scanned_at = scan.stamp
        self._push()

    @hears(SonarRead)
    async def listen_around(self, sonar: SonarRead) -> None:
        """The sonar has heard something."""
        self._perception.take(sonar)
        if not 0.0 <= sonar.stamp - self._scanned_at < self.parameters.sonar_alone:
            self._push()

    def _push(self) -> None:
        self._say_faults()
        if self.outline is None:
            return
        perceived = self._perception.perceived()
        if perceived is None:
            return
        read = obstacles(self.parameters.detection, self.outline, perceived)
        self._dead_ends = self._dead_ends + 1 if read.is_dead_end else 0
        is_dead_end = self._dead_ends >= self.parameters.dead_end_after
        self.push(replace(read, is_dead_end=is_dead_end))

    def _say_faults(self) -> None:
        """Once, though it is found with each reading."""
        faults = tuple(fault for fault in self._perception.faults if not fault.endswith("yet"))
        for fault in faults:
            if fault not in self._said:
                self.home.report(self.name, f"{fault}, and is left out; see whether it is switched on and free", None)
        self._said = faults

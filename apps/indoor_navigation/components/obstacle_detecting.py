"""Watch what is in the way, and say what is free."""

from dataclasses import dataclass, field, replace
from math import inf

from apps.indoor_navigation.algorithms.bystanders import MovedPlaces
from apps.indoor_navigation.algorithms.obstacle_detection import DetectionNumbers, obstacles
from apps.indoor_navigation.algorithms.senses import Senses, SensesNumbers
from apps.indoor_navigation.algorithms.walkers import ScanMotion
from apps.indoor_navigation.component import Role, hears
from apps.indoor_navigation.components.embodied import Embodied
from apps.indoor_navigation.data import LaserRead, ObstRead, SonarRead


@dataclass(frozen=True, slots=True)
class DetectingNumbers:
    """What it believes and what it calls an obstacle.

    sonar_alone: s after the last scan, from which on it says something with each reading of the sonar. dead_end_after:
    readings one after the other that find no way on, before it says so.
    """

    sonar_alone: float = 0.25
    dead_end_after: int = 3
    senses: SensesNumbers = field(default_factory=SensesNumbers)
    detection: DetectionNumbers = field(default_factory=DetectionNumbers)


class ObstacleDetecting(Embodied):
    """Says with each scan, or without scans with each reading of the sonar, what both see."""

    role = Role.MONITOR
    gives = (ObstRead,)
    numbers_type = DetectingNumbers

    async def setup(self) -> None:
        """Know nothing yet."""
        self._senses = Senses(self.numbers.senses)
        self._scanned_at = -inf
        self._motion, self._bystanders = ScanMotion(), MovedPlaces()
        self._dead_ends = 0
        self._said: tuple[str, ...] = ()
        await super().setup()

    @hears(LaserRead)
    async def look(self, scan: LaserRead) -> None:
        """The laser has seen something."""
        self._senses.take(scan)
        self._scanned_at = scan.stamp
        self._bystanders.see(scan.stamp, *self._motion.look(scan))
        self._push()

    @hears(SonarRead)
    async def listen_around(self, sonar: SonarRead) -> None:
        """The sonar has heard something."""
        self._senses.take(sonar)
        if not 0.0 <= sonar.stamp - self._scanned_at < self.numbers.sonar_alone:
            self._push()

    def _push(self) -> None:
        self._say_faults()
        if self.outline is None:
            return
        senses = self._senses
        rays = senses.rays()
        if not len(rays.end_x):
            return
        read = obstacles(self.numbers.detection, self.outline, senses.stamp, senses.pose, rays)
        self._dead_ends = self._dead_ends + 1 if read.is_dead_end else 0
        is_dead_end = self._dead_ends >= self.numbers.dead_end_after
        people_x, people_y = self._bystanders.about(senses.stamp, rays)
        self.push(replace(read, is_dead_end=is_dead_end, people_x=people_x, people_y=people_y))

    def _say_faults(self) -> None:
        """Once, though it is found with each reading."""
        faults = tuple(fault for fault in self._senses.faults if not fault.endswith("yet"))
        for fault in faults:
            if fault not in self._said:
                self.home.report(self.name, f"{fault}, and is left out; see whether it is switched on and free", None)
        self._said = faults

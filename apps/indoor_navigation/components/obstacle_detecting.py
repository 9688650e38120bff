"""The component that reports obstacles and free space."""

from dataclasses import dataclass, replace
from math import inf

from apps.indoor_navigation.algorithms.obstacle_detection import DetectionParameters, obstacles
from apps.indoor_navigation.algorithms.perception import Perception, PerceptionParameters
from apps.indoor_navigation.component import Role, hears
from apps.indoor_navigation.components.embodied import Embodied
from apps.indoor_navigation.data import LaserRead, ObstRead, SonarRead


@dataclass(frozen=True, slots=True)
class _DetectingParameters:
    """senses: of the perception. detection: of obstacles.

    sonar_alone: s after the last scan from which on each reading of the sonar is reported. dead_end_after: consecutive
    readings without a way on before a dead end is reported.
    """

    sonar_alone: float
    dead_end_after: int
    senses: PerceptionParameters
    detection: DetectionParameters


class ObstacleDetecting(Embodied):
    """Pushes ObstRead with each scan, or without scans with each reading of the sonar."""

    role = Role.MONITOR
    gives = (ObstRead,)
    parameters_type = _DetectingParameters

    async def setup(self) -> None:
        """Begin without readings."""
        self._perception = Perception(self.parameters.senses)
        self._scanned_at = -inf
        self._dead_ends = 0
        self._reported: tuple[str, ...] = ()
        await super().setup()

    def woken(self, slept: float) -> None:
        """Forget the readings from before the sleep, so that the sensor that is read last is not taken for silent."""
        self._perception.forget()
        self._dead_ends = 0

    @hears(LaserRead)
    async def look(self, scan: LaserRead) -> None:
        """Take a scan, and report."""
        self._perception.take(scan)
        self._scanned_at = scan.stamp
        self._push()

    @hears(SonarRead)
    async def listen_around(self, sonar: SonarRead) -> None:
        """Take a reading of the sonar, and report if there are no scans."""
        self._perception.take(sonar)
        if not 0.0 <= sonar.stamp - self._scanned_at < self.parameters.sonar_alone:
            self._push()

    def _push(self) -> None:
        self._report_faults()
        if self.outline is None:
            return
        perceived = self._perception.perceived(self.outline)
        if perceived is None:
            return
        read = obstacles(self.parameters.detection, self.outline, perceived)
        self._dead_ends = self._dead_ends + 1 if read.is_dead_end else 0
        is_dead_end = self._dead_ends >= self.parameters.dead_end_after
        self.push(replace(read, is_dead_end=is_dead_end))

    def _report_faults(self) -> None:
        """Report each fault once, though each reading shows it."""
        faults = tuple(fault for fault in self._perception.faults if not fault.endswith("yet"))
        for fault in faults:
            if fault not in self._reported:
                self.home.report(self.name, f"{fault}, and is ignored; check whether it is switched on and free", None)
        self._reported = faults

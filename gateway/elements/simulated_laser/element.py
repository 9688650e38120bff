"""The laser that simulators of the MobileSim family send on the robot's own line.

The simulator sends a sweep after each SIP once it is told to, in packets of some readings each. The packets say how
many readings a sweep has, but not where it looks: first and last bearing are set here, and the step follows from both.
Source: fact sheet section 7.
"""

from math import inf, pi

from gateway.elements.element import Element
from gateway.events import SweepReceived
from p2os import Command, ExtendedLaser, RobotModel, SimulatedLaser
from p2os.simulator_packets import SimulatedLaserMode

FIRST_BEARING, LAST_BEARING = -pi / 2, pi / 2
"""rad; simulators accept only bearings that lie symmetrically about straight ahead."""
MODES = (
    SimulatedLaserMode.EXTENDED,
    SimulatedLaserMode.EXTENDED,
    SimulatedLaserMode.PLAIN,
    SimulatedLaserMode.EXTENDED,
    SimulatedLaserMode.PLAIN,
)
"""In the order in which they are tried."""
PATIENCE = 1.0
"""Seconds to wait for a packet before the next try."""
SILENCE = 2.0
"""Seconds without a sweep after which the laser is asked for again."""
SMOOTHING = 0.1
"""Part of each new interval in the mean between sweeps."""


class SimulatedLaserScanner(Element[SimulatedLaser | ExtendedLaser]):
    """Requests the laser of a simulator and assembles its sweeps.

    is_present: a whole sweep has come. beams: readings in the last one.
    """

    takes = (SimulatedLaser, ExtendedLaser)
    beams = 0
    _tries_left = 0
    _period = 0.0
    _swept_at: float | None = None

    def begin_link(self, model: RobotModel, now: float) -> None:
        """Ask only where the settings want it, until the robot turns out to be a simulator's."""
        self._tries_left = 0
        self._swept_at = None
        self._forget_sweep()
        if self._settings.fitted.simulated_laser:
            self.meet_simulator(now)

    def meet_simulator(self, now: float) -> None:
        """Ask; not where the settings do not want it, nor on a line that carries no streams."""
        if self._settings.fitted.simulated_laser is False or not self._settings.line.streams:
            return
        if self.deadline == inf:
            self._tries_left = len(MODES)
            self.watch(now)

    def lose_link(self) -> None:
        """Ask no more."""
        self.deadline = inf

    def watch(self, now: float) -> None:
        """Ask, once or again; a laser that was there is asked for as long as the robot is."""
        if self.is_present and not self._tries_left:
            self._tries_left = len(MODES)
        if not self._tries_left:
            self.deadline = inf
            return
        mode = MODES[len(MODES) - self._tries_left]
        self._tries_left -= 1
        self._ask(Command.SIM_LRF_SET_FOV_START, FIRST_BEARING)
        self._ask(Command.SIM_LRF_SET_FOV_END, LAST_BEARING)
        self._ask(Command.SIM_LRF_ENABLE, mode)
        self.deadline = now + PATIENCE

    def take(self, packet: SimulatedLaser | ExtendedLaser, now: float) -> None:
        """Add the readings to the sweep; one of which a packet was lost is not published."""
        if packet.first == 0:
            self._forget_sweep()
            self._began = now
        if packet.first != len(self._ranges):
            self._forget_sweep()
            return
        if isinstance(packet, ExtendedLaser):
            self._ranges += [reading.range for reading in packet.readings]
            self._reflectances += [reading.reflectance for reading in packet.readings]
        else:
            self._ranges += packet.ranges
        if len(self._ranges) == packet.total > 1:
            self._finish(now)

    def _finish(self, now: float) -> None:
        if self._swept_at is not None:
            interval = now - self._swept_at
            self._period = self._period + SMOOTHING * (interval - self._period) if self._period else interval
        self._swept_at = now
        self.is_present = True
        self.beams = len(self._ranges)
        self._tries_left = len(MODES)
        self.deadline = now + SILENCE
        self._announce(
            SweepReceived(
                ranges=tuple(self._ranges),
                reflectances=tuple(self._reflectances) if len(self._reflectances) == len(self._ranges) else (),
                first_bearing=FIRST_BEARING,
                step=(LAST_BEARING - FIRST_BEARING) / (len(self._ranges) - 1),
                age=now - self._began,
                period=self._period,
            )
        )
        self._forget_sweep()

    def _forget_sweep(self) -> None:
        self._ranges: list[float] = []
        self._reflectances: list[int] = []
        self._began = inf

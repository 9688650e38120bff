"""The line between firmware and port: the effects of a cable on bytes.

A line is a list of stages in each direction. The ideal line has none: a frame leaves in the step that made it, in one
write. Faults are stages that come and go. Time is an argument, and every chance is drawn from the line's own seed.
"""

from collections.abc import Callable, Mapping
from random import Random
from typing import Literal

from p2os.framing import split_frames
from p2os_emu.links.adapter import Blocks
from p2os_emu.links.impairments import BitErrors, Freeze, Noise, Silence
from p2os_emu.links.link import Link
from p2os_emu.links.modem import Dialling, Slot
from p2os_emu.links.pacing import BaudCheck, HostQueue, RobotQueue
from p2os_emu.links.profile import LinkProfile
from p2os_emu.links.stage import LinkStage, Rates

__all__ = ["LINE_FAULTS", "EmulatedLine", "LinkProfile", "Source", "Toward", "split_frames"]

Toward = Literal["robot", "host", "both"]
"""Which way bytes travel."""
Source = Literal["host", "robot"]
"""Who sent them."""


class _Way:
    """One direction.

    stages: what the profile puts there. faults: what has gone wrong, by name.
    late: bytes that a fault has kept and now lets go.
    """

    def __init__(self) -> None:
        self.stages: list[LinkStage] = []
        self.faults: dict[str, LinkStage] = {}
        self.late = b""

    @property
    def is_plain(self) -> bool:
        """Whether bytes leave as they enter."""
        return not (self.stages or self.faults or self.late)

    def carry(self, data: bytes, now: float, rates: Rates) -> bytes:
        """As `LinkStage.carry`, through all of them."""
        for stage in self.stages:
            data = stage.carry(data, now, rates)
        data, self.late = self.late + data, b""
        for stage in self.faults.values():
            data = stage.carry(data, now, rates)
        return data


class EmulatedLine:
    """One robot's line to its port.

    is_cut: while set, nothing gets through in either direction.
    is_plain: bytes leave as they enter, in both directions.
    tap: called with time, sender and bytes for whatever the port carries; None if nobody listens.
    """

    def __init__(self, link: Link, profile: LinkProfile, seed: int = 0) -> None:
        self.link = link
        self.is_cut = False
        self.tap: Callable[[float, Source, bytes], None] | None = None
        self._seed = seed
        self._impaired: dict[str, tuple[Toward, float]] = {}
        self._to_robot = _Way()
        self._to_host = _Way()
        self._lay(profile)
        self._note_effects()

    @property
    def faults(self) -> list[str]:
        """The names of what has gone wrong with `impair`."""
        return [name for name in LINE_FAULTS if name in self._impaired]

    def impair(self, name: str, *, toward: Toward = "both", rate: float = 1e-3) -> None:
        """Apply a fault until `mend`; a second call replaces it if the values differ.

        Args:
            name: One of `LINE_FAULTS`.
            toward: Which way the bytes travel that it befalls; "half-duplex" loses those toward one end.
            rate: Of "noisy": fraction of bits turned round.
        Raises:
            KeyError: There is no such fault.
        """
        make = LINE_FAULTS[name]
        if self._impaired.get(name) == (toward, rate):
            return
        self.mend(name)
        self._impaired[name] = toward, rate
        for end, way in (("robot", self._to_robot), ("host", self._to_host)):
            if toward in (end, "both"):
                way.faults[name] = make(Random(f"{self._seed} {name} {end}"), rate)
        self._note_effects()

    def mend(self, name: str) -> None:
        """End a fault; bytes that it held back arrive with the next ones."""
        self._impaired.pop(name, None)
        for way in (self._to_robot, self._to_host):
            fault = way.faults.pop(name, None)
            if isinstance(fault, Freeze):
                way.late += bytes(fault.held)
        self._note_effects()

    def receive(self, now: float, host_baud: int) -> bytes:
        """Take the bytes that reach the firmware now.

        Args:
            now: Steady time, s; never less than at the call before.
            host_baud: The rate the firmware has set, bit/s.
        """
        data = self.link.read() if self.link.inbox else b""
        if data and self.tap is not None:
            self.tap(now, "host", data)
        if not self.is_plain:
            data = self._to_robot.carry(data, now, Rates(host_baud, self.link.client_baud))
            self._note_effects()
        return b"" if self.is_cut else data

    def send(self, data: bytes, now: float, host_baud: int) -> None:
        """Take whole frames from the firmware and write to the port what leaves the line now; call it every step.

        Args:
            data: Frames, one after another; each is its own write where nothing treats them on the way.
            now: Steady time, s; never less than at the call before.
            host_baud: The rate the firmware has set, bit/s.
        """
        if not self.is_plain and not self._to_host.is_plain:
            data = self._to_host.carry(data, now, Rates(host_baud, self.link.client_baud))
            self._note_effects()
            if data and not self.is_cut:
                self._write(data, now)
        elif data and not self.is_cut:
            for frame in split_frames(data):
                self._write(frame, now)

    def _note_effects(self) -> None:
        self.is_plain = self._to_robot.is_plain and self._to_host.is_plain

    def _write(self, data: bytes, now: float) -> None:
        if self.tap is not None:
            self.tap(now, "robot", data)
        self.link.write(data)

    def _lay(self, profile: LinkProfile) -> None:
        """Put the profile's stages in the order in which the bytes of each direction meet them."""
        modem = profile.modem
        baud = modem.baud if modem else None
        if profile.enforces_baud:
            # First of all: a host may have set another rate by the time its bytes arrive.
            self._to_robot.stages.append(BaudCheck(Random(f"{self._seed} baud robot"), baud))
        if profile.paces:
            self._to_robot.stages.append(HostQueue(profile.host_buffer_bytes, baud))
            self._to_host.stages.append(RobotQueue(profile.buffer_bytes, baud))
        if profile.enforces_baud:
            self._to_host.stages.append(BaudCheck(Random(f"{self._seed} baud host"), baud))
        dialling = Dialling(modem) if modem else None
        if dialling:
            self._to_robot.stages.append(dialling.to_robot)
        if modem and modem.slot:
            self._to_robot.stages.append(Slot(modem.slot, 0))
            self._to_host.stages.append(Slot(modem.slot, 1))
        self._to_robot.stages += profile.to_robot.stages(f"{self._seed} robot")
        self._to_host.stages += profile.to_host.stages(f"{self._seed} host")
        if dialling:
            self._to_host.stages.append(dialling.to_host)
        if profile.adapter:
            self._to_host.stages.append(Blocks(profile.adapter))


LINE_FAULTS: Mapping[str, Callable[[Random, float], LinkStage]] = {
    "half-duplex": lambda rng, rate: Silence(),
    "frozen": lambda rng, rate: Freeze(),
    "noisy": lambda rng, rate: BitErrors(rate, rng),
    "garbled": lambda rng, rate: Noise(rng),
}
"""What may go wrong with a line, by name."""

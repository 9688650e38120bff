"""Properties of a line, from a file in configs/links."""

from dataclasses import dataclass, field, replace

from p2os_emu.links.adapter import Adapter
from p2os_emu.links.impairments import Impairments
from p2os_emu.links.modem import Modem


@dataclass(frozen=True, slots=True)
class LinkProfile:
    """Properties of one line.

    summary: one line for people.
    enforces_baud: whether bytes arrive as garbage when the client's rate is not the robot's.
    paces: whether bytes take their time, ten bits each at the line's rate.
    buffer_bytes: how many bytes wait in the robot for a paced line before frames are dropped.
    host_buffer_bytes: likewise in the client's computer; a real one lets the client wait then.
    adapter: a USB adapter at the client's end. modem: a pair of radio modems between the ends.
    to_robot, to_host: what goes wrong in each direction.
    """

    summary: str
    enforces_baud: bool = False
    paces: bool = False
    buffer_bytes: int = 4096
    host_buffer_bytes: int = 4096
    adapter: Adapter | None = None
    modem: Modem | None = None
    to_robot: Impairments = field(default_factory=Impairments)
    to_host: Impairments = field(default_factory=Impairments)

    @property
    def of_accessories(self) -> "LinkProfile":
        """The profile of accessory cables: without modem and without radio impairments."""
        if self.modem is None:
            return self
        return replace(self, modem=None, to_robot=Impairments(), to_host=Impairments())

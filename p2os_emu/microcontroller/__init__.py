"""The microcontroller: a robot's firmware, emulated without port and clock."""

from p2os_emu.microcontroller.commands import EMULATED, EMULATED_PACKETS
from p2os_emu.microcontroller.flash import Flash
from p2os_emu.microcontroller.microcontroller import Microcontroller

__all__ = ["EMULATED", "EMULATED_PACKETS", "Flash", "Microcontroller"]

"""Print PROTOCOL.md: the tables of `p2os` and how much of them the emulator implements."""

from p2os.compliance import Emulated
from p2os_emu.microcontroller import EMULATED, EMULATED_PACKETS, simulator


def page() -> str:
    """The page as it should be committed."""
    return Emulated(EMULATED, EMULATED_PACKETS, simulator.COMMANDS, simulator.PACKETS).page()


if __name__ == "__main__":
    print(page(), end="")

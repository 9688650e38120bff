"""Print PROTOCOL.md: the tables of `p2os` and what the emulator's microcontroller makes of them."""

from p2os.compliance import render
from p2os_emu.microcontroller import EMULATED, EMULATED_PACKETS


def page() -> str:
    """The page as it should be committed."""
    return render(EMULATED, EMULATED_PACKETS)


if __name__ == "__main__":
    print(page(), end="")

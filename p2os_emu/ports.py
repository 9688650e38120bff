"""Which port each robot gets: a pseudo-terminal, behind a fixed name if one is asked for, or a TCP port."""

from pathlib import Path

from p2os_emu.links.link import Link
from p2os_emu.links.poller import Poller
from p2os_emu.links.pty import PtyLink
from p2os_emu.links.tcp import TcpLink


class Ports:
    """Opens one port after another.

    Args:
        poller: Tells the ports when bytes have come.
        pty: Symbolic link to the pseudo-terminal; None for none. Of several robots each has its own: PATH-NAME.
        tcp: TCP port of the first robot, the next robots get the numbers after it; 0 lets the system choose each; None
            for pseudo-terminals.
        several: Whether there is more than one robot from the start.
    """

    def __init__(
        self, poller: Poller, *, pty: Path | None = None, tcp: int | None = None, several: bool = False
    ) -> None:
        self._poller = poller
        self._pty = pty
        self._tcp = tcp
        self._several = several
        self._opened = 0

    def open(self, name: str) -> Link:
        """Open the port of the next robot.

        Raises:
            PortError: It cannot be opened.
        """
        index = self._opened
        if self._tcp is not None:
            link: Link = TcpLink(self._poller, self._tcp + index if self._tcp else 0)
        else:
            link = PtyLink(self._poller, self._path(name, index))
        self._opened += 1
        return link

    def _path(self, name: str, index: int) -> Path | None:
        # A robot added to a single one that has the plain name gets a name of its own.
        if self._pty is None or (index == 0 and not self._several):
            return self._pty
        return self._pty.with_name(f"{self._pty.name}-{name}")

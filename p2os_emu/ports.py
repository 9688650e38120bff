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
        robots: How many robots there are from the start.
    """

    def __init__(self, poller: Poller, *, pty: Path | None = None, tcp: int | None = None, robots: int = 1) -> None:
        self._poller = poller
        self._pty = pty
        self._tcp = tcp
        self._robots = robots
        self._opened = self._cables = 0

    def open(self, name: str) -> Link:
        """Open the port of the next robot.

        Raises:
            PortError: It cannot be opened.
        """
        index = self._opened
        if self._tcp is not None:
            link: Link = TcpLink(self._poller, self._tcp + self._place(index) if self._tcp else 0)
        else:
            link = PtyLink(self._poller, self._path(name, index))
        self._opened += 1
        return link

    def open_cable(self, name: str, part: str) -> Link:
        """Open a port for an accessory of the robot that was opened last; its TCP port comes after all robots' ports.

        Raises:
            PortError: It cannot be opened.
        """
        if self._tcp is not None:
            self._cables += 1
            number = self._tcp + max(self._robots, self._opened) + self._cables - 1
            return TcpLink(self._poller, number if self._tcp else 0)
        path = self._path(name, self._opened - 1)
        return PtyLink(self._poller, path and path.with_name(f"{path.name}-{part}"))

    def _place(self, index: int) -> int:
        """Robots that come later find the accessories' ports taken."""
        return index if index < self._robots else index + self._cables

    def _path(self, name: str, index: int) -> Path | None:
        # A robot added to a single one that has the plain name gets a name of its own.
        if self._pty is None or (index == 0 and self._robots == 1):
            return self._pty
        return self._pty.with_name(f"{self._pty.name}-{name}")

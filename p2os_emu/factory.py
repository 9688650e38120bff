"""One robot for each client: a TCP port where every connection gets a robot, which is removed with the connection."""

import socket
import sys

from configs import ConfigError
from p2os_emu.links.link import PortError
from p2os_emu.links.poller import Poller
from p2os_emu.links.tcp import ClientLink, address, listen
from p2os_emu.team import EmulatedTeam


class Factory:
    """Makes robots of one model.

    port: what clients open, for people and programs. model: of the robots.
    """

    def __init__(self, poller: Poller, team: EmulatedTeam, model: str, port: int) -> None:
        """Listen.

        Args:
            poller: Tells when clients come and go.
            team: Makes the robots.
            model: One of `configs/robots`, or a path to a file.
            port: TCP port; 0 lets the system choose.
        Raises:
            PortError: The port cannot be had.
        """
        self.model = model
        self._poller = poller
        self._team = team
        self._waiting: list[socket.socket] = []
        self._visitors: dict[str, ClientLink] = {}
        self._listener = listen(port)
        self.port = address(self._listener)
        poller.watch(self._listener.fileno(), self._on_knock)

    def tend(self) -> None:
        """Between two steps: make robots for new clients, and remove the robots of clients that are gone."""
        while self._waiting:
            self._serve(self._waiting.pop(0))
        for name in [name for name, link in self._visitors.items() if not link.attached]:
            del self._visitors[name]
            if name in self._team.emulator.robots:  # nobody has removed it by hand
                self._team.emulator.remove(name)

    def close(self) -> None:
        """Stop listening; the robots belong to the emulator."""
        self._poller.forget(self._listener.fileno())
        self._listener.close()
        for connection in self._waiting:
            connection.close()

    def _on_knock(self, events: int) -> None:
        try:
            connection, _ = self._listener.accept()
        except OSError:
            # It was gone before it was let in.
            return
        self._waiting.append(connection)

    def _serve(self, connection: socket.socket) -> None:
        link = ClientLink(self._poller, connection)
        try:
            robot = self._team.add(self.model, link=link)
        except (ConfigError, PortError) as error:
            link.close()
            print(f"p2os-emu: a client was turned away: {error}", file=sys.stderr, flush=True)
            return
        self._visitors[robot.name] = link

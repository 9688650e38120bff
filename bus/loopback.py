"""The bus profile `local`: sessions on one machine that find each other without any network.

A session listens on a loopback address that belongs to its bus alone, and is registered as a Unix socket in the
abstract namespace. That namespace has the same scope as the loopback interface, leaves no files, and an entry goes with
its process, however that ends. Each session connects to all that were registered before it, so that for each pair one
of the two connects, and connects again whenever the link is lost. Zenoh's own scouting is off: it would keep UDP
sockets on all interfaces, and connect to whatever address a datagram names.
"""

import errno
import hashlib
import re
import socket
from contextlib import ExitStack
from pathlib import Path
from typing import NamedTuple

from bus.bus import Closeable
from bus.errors import BusUnavailable
from configs.loader import ConfigError

GROUP = "224.0.0.224"  # Zenoh's own
DEFAULT_PORT = 7446  # likewise
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,39}")
SOCKETS = Path("/proc/net/unix")


class LocalBus(NamedTuple):
    """One of the buses on this machine.

    name: as in `local:NAME`; empty for `local` itself.
    """

    name: str = ""

    @classmethod
    def named(cls, name: str) -> "LocalBus":
        """Return the bus of this name.

        Raises:
            ConfigError: The name is not valid.
        """
        if name and not NAME.fullmatch(name):
            rule = "1 to 40 letters, digits, '.', '_' or '-', beginning with a letter or a digit"
            raise ConfigError(f"{name[:60]!r} is not a valid name of a local bus; use {rule}")
        return cls(name)

    @property
    def address(self) -> str:
        """The loopback address on which its sessions listen.

        Each bus has its own. A session goes on connecting to the address of one that has ended, and must not reach a
        program of another bus that was given the same port.
        """
        first, second, third = self._digest()[:3]
        return f"127.{1 + first % 254}.{second}.{1 + third % 254}"

    @property
    def scouting_address(self) -> tuple[str, int]:
        """Multicast group and port, on the loopback interface, for finding plain Zenoh programs."""
        number = int.from_bytes(self._digest()[3:7], "big")
        return GROUP, 20000 + number % 40000 if self.name else DEFAULT_PORT

    @property
    def _registry(self) -> str:
        return f"acromovi/local:{self.name}/"

    def entries(self) -> list["_SessionEntry"]:
        """Return the sessions that are registered, oldest first.

        Raises:
            BusUnavailable: The kernel does not tell which sockets there are.
        """
        try:
            rows = SOCKETS.read_text(encoding="utf-8", errors="replace").splitlines()  # only figures are read
        except OSError as err:
            why = f"{SOCKETS} cannot be read ({err.strerror})"
            raise BusUnavailable(f"the profile local needs /proc to find other programs, and {why}") from err
        found = set()
        for row in rows:
            path = row.rpartition(" ")[2]
            if path.startswith(f"@{self._registry}"):
                serial, _, port = path.removeprefix(f"@{self._registry}").partition("/")
                if serial.isdecimal() and port.isdecimal():
                    found.add(_SessionEntry(int(serial), int(port)))
        return sorted(found)

    def endpoint(self, entry: "_SessionEntry") -> str:
        """Return the address of a registered session, as Zenoh writes it."""
        return f"tcp/{self.address}:{entry.port}"

    def _digest(self) -> bytes:
        return hashlib.sha256(f"acromovi local:{self.name}".encode()).digest()


class _SessionEntry(NamedTuple):
    """A registered session. serial: later sessions have higher ones. port: where it listens."""

    serial: int
    port: int


class Registration(Closeable):
    """The entry of one session, from before it is opened until it is closed.

    endpoint: where the session listens.
    elders: where those listen that were registered before, for this session to connect to.
    """

    def __init__(self, bus: LocalBus) -> None:
        """Register a session.

        There is no lock, so a process that is stopped here does not block the others: a session that finds after
        registering that its entry is not the last one tries again with a later one. So of two sessions at least the
        later one sees the other.

        Raises:
            BusUnavailable: This machine does not allow it.
        """
        # Who has seen an entry that was withdrawn connects to its port. If another session were given that port, the
        # two would connect to each other, so it is held as long as this session is registered.
        self._held = ExitStack()
        try:
            own, entries = self._registered(bus)
        except BaseException:
            self._held.close()
            raise
        self.endpoint = bus.endpoint(own)
        self.elders = tuple(bus.endpoint(entry) for entry in entries[:-1])

    def _registered(self, bus: LocalBus) -> tuple[_SessionEntry, list[_SessionEntry]]:
        """Register; return the own entry, and all entries up to this one."""
        while True:
            before = bus.entries()
            probe = _on_free_port(bus.address)
            own = _SessionEntry(max((entry.serial for entry in before), default=0) + 1, probe.getsockname()[1])
            self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
            try:
                self._socket.bind(f"\0{bus._registry}{own.serial}/{own.port}")
            except OSError as err:
                self._socket.close()
                self._held.enter_context(probe)
                if err.errno == errno.EADDRINUSE:  # by a session that registers at the same time
                    continue
                raise BusUnavailable(f"a session cannot be registered on this machine: {err.strerror}") from err
            entries = bus.entries()
            # One that has registered and does not listen yet may have been given the same port.
            if entries and entries[-1] == own and all(entry.port != own.port for entry in entries[:-1]):
                probe.close()  # for Zenoh to listen there
                return own, entries
            self._socket.close()
            self._held.enter_context(probe)
            if own not in entries:
                raise BusUnavailable(f"{SOCKETS} does not show this program's own sockets; is /proc mounted for it?")

    @property
    def configuration(self) -> dict[str, list[str]]:
        """Zenoh's settings of the session's own address, and of the sessions to which it connects."""
        return {"listen/endpoints": [self.endpoint], "connect/endpoints": list(self.elders)}

    def close(self) -> None:
        """Withdraw the entry."""
        self._socket.close()
        self._held.close()


def _on_free_port(address: str) -> socket.socket:
    """Return a socket on a port on which nobody listens; nobody else is given it as long as the socket is open."""
    probe = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    try:
        probe.bind((address, 0))
    except OSError as err:
        probe.close()
        raise BusUnavailable(f"no session can listen on {address}: {err.strerror}") from err
    return probe

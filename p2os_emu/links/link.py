"""Interface of all ports: a link carries bytes between one robot and at most one client."""

import os
from abc import ABC, abstractmethod


class PortError(Exception):
    """A port cannot be opened as asked; the message says why and what to do."""


class Link(ABC):
    """The robot's side of one port. Nothing here waits: what cannot be sent now is dropped and counted.

    inbox: bytes from the client that the robot has not read yet.
    port: what a client opens, for people and for `--json`; changes when the port vanishes and returns without a fixed
        name.
    dropped: frames that found no room because the client does not read.
    """

    port: str
    dropped: int = 0

    def __init__(self) -> None:
        self.inbox = bytearray()

    @property
    @abstractmethod
    def attached(self) -> bool:
        """Whether a client is known to hold the port."""

    @property
    def client_baud(self) -> int | None:
        """The rate the client has set, bit/s; None where a port knows no rate."""
        return None

    def read(self) -> bytes:
        """Take all the bytes that have come since the last read; empty when there are none."""
        data = bytes(self.inbox)
        self.inbox.clear()
        return data

    @abstractmethod
    def write(self, data: bytes) -> None:
        """Hand bytes to the client in one piece."""

    @abstractmethod
    def unplug(self) -> None:
        """Remove the port while a client uses it, as when a USB cable is pulled."""

    @abstractmethod
    def plug_in(self) -> None:
        """Restore the port after `unplug`."""

    @abstractmethod
    def close(self) -> None:
        """Release all resources; the port is removed permanently."""


class Outlet:
    """Writes to a descriptor that may be full.

    A piece that was begun is finished before the next one, so that a client that reads slowly loses whole frames and
    never the end of one.
    """

    def __init__(self) -> None:
        self._rest = b""

    def write(self, descriptor: int, data: bytes) -> bool:
        """Write what fits; False when `data` was dropped because there is no room for it.

        Raises:
            OSError: The descriptor is broken.
        """
        try:
            if self._rest:
                self._rest = self._rest[os.write(descriptor, self._rest) :]
                if self._rest:
                    return False
            self._rest = data[os.write(descriptor, data) :]
        except BlockingIOError:  # it takes no more now; the rest goes first later
            return False
        return True

    def clear(self) -> None:
        """Drop the rest of a partly written piece: its reader is gone."""
        self._rest = b""

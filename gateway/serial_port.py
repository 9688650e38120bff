"""Serial ports: the only file that opens a device. A path, `socket://host:port`, or any URL that pyserial knows.

Reading never blocks: wait with `select` on `fileno()`, then `read` takes what is there. Modem lines that a port does
not have (a pseudo-terminal has none) do not matter.
"""

import errno
import grp
import os
import queue
import socket
import stat
import termios
import threading
from abc import ABC, abstractmethod
from contextlib import suppress
from pathlib import Path
from urllib.parse import urlsplit

import serial

from gateway.errors import ExitCode, GatewayError, NoSuchPort, PortBusy, PortLost
from gateway.local_ports import user_of_terminal

READ_SIZE = 4096
SOCKET = "socket"
CONNECT_TIMEOUT = 2.0
"""Seconds for a TCP connection to come about."""
PUMP_TIMEOUT = 0.1
"""Seconds after which the reader of a port without a descriptor looks whether it is to end."""
MOST_WAITING = 64
"""Frames that wait to be written to such a port; one that takes no more is dead."""

_RATES = {getattr(termios, name): int(name[1:]) for name in dir(termios) if name[:1] == "B" and name[1:].isdigit()}


class Port(ABC):
    """An open port.

    name: for people. rate: bit/s that it had when it was opened, None where it has none to set.
    """

    name: str
    rate: int | None

    @abstractmethod
    def fileno(self) -> int:
        """Return the descriptor to wait on."""

    @abstractmethod
    def set_rate(self, rate: int) -> None:
        """Send and receive at so many bit/s from now on.

        Raises:
            PortLost: The port is gone.
        """

    @abstractmethod
    def close(self) -> None:
        """Let go of the port. Closing twice does no harm."""

    def read(self) -> bytes:
        """Take what has come; empty if there is nothing after all.

        Raises:
            PortLost: The port is gone.
        """
        try:
            data = os.read(self.fileno(), READ_SIZE)
        except BlockingIOError:
            return b""
        except OSError as err:
            raise PortLost(f"{self.name} is gone: {err.strerror}") from err
        if not data:
            raise PortLost(f"{self.name} is gone: the other end was closed")
        return data

    def write(self, data: bytes) -> None:
        """Send bytes; they are few, and a line that does not take them at once is dead.

        Raises:
            PortLost: The port is gone, or takes no more.
        """
        try:
            written = os.write(self.fileno(), data)
        except OSError as err:
            raise PortLost(f"{self.name} is gone: {err.strerror}") from err
        if written < len(data):
            raise PortLost(f"{self.name} takes no more bytes")


def open_port(name: str) -> Port:
    """Open a port by its path or URL.

    Raises:
        GatewayError: NoSuchPort, PortBusy or another; the message says what to do.
    """
    scheme = urlsplit(name).scheme if "://" in name else ""
    if not scheme:
        return _DevicePort(name)
    if scheme == SOCKET:
        return SocketPort(name)
    return _PumpedPort(name)


def has_rate(name: str) -> bool:
    """Return whether the port of this name or URL has a rate to set; a socket has none."""
    return urlsplit(name).scheme != SOCKET


class _DevicePort(Port):
    """A device: a UART, an adapter, a pseudo-terminal."""

    def __init__(self, path: str) -> None:
        self.name = path
        if (user := user_of_terminal(path)) is not None:  # whose keys would be read as bytes of a robot
            raise _not_a_port(f"{path} is the terminal in which {user} runs")
        # Opened twice, so that the rate which the last client left is seen before pyserial sets its own.
        probe = _open_device(path)
        try:
            self.rate = _RATES.get(termios.tcgetattr(probe)[5], 0)
            self._serial = serial.Serial(path, timeout=0, exclusive=True)
        except termios.error as err:
            raise _not_a_port(f"{path} is no serial port") from err
        except serial.SerialException as err:
            raise _explain(path, err.errno) from err
        finally:
            os.close(probe)
        with suppress(OSError, ValueError, NotImplementedError):  # only some adapters can hand on bytes at once
            self._serial.set_low_latency_mode(True)
        self._rate_set = int(self._serial.baudrate)

    def fileno(self) -> int:
        """Return the descriptor to wait on."""
        return int(self._serial.fileno())

    def set_rate(self, rate: int) -> None:
        """Send and receive at so many bit/s from now on."""
        if rate == self._rate_set:
            return
        try:
            self._serial.baudrate = rate
        except (OSError, ValueError, termios.error) as err:
            raise PortLost(f"{self.name} cannot be set to {rate} bit/s: {err}") from err
        self._rate_set = rate

    def close(self) -> None:
        """Let go of the port."""
        self._serial.close()


class SocketPort(Port):
    """A TCP connection, as serial servers, wireless bridges and simulators offer it."""

    rate = None

    def __init__(self, url: str) -> None:
        self.name = url
        host, port = _address(url)
        try:
            self._socket = socket.create_connection((host, port), CONNECT_TIMEOUT)
        except OSError as err:
            reason = err.strerror or str(err)
            raise NoSuchPort(
                f"nothing answers at {url} ({reason}); start the server there, or correct the address"
            ) from err
        self._socket.setblocking(False)
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

    def fileno(self) -> int:
        """Return the descriptor to wait on."""
        return self._socket.fileno()

    def set_rate(self, rate: int) -> None:
        """Do nothing: the serial server at the other end has the rate."""

    def close(self) -> None:
        """Close the connection."""
        self._socket.close()


class _PumpedPort(Port):
    """Any other URL of pyserial's (`rfc2217://`): it has no descriptor, and its calls wait for the server.

    So one thread pumps what it reads into a pipe, and another one writes.
    """

    def __init__(self, url: str) -> None:
        self.name = url
        try:
            self._serial = serial.serial_for_url(url, timeout=PUMP_TIMEOUT)
        except ValueError as err:
            raise NoSuchPort(
                f"{url} is no port: {err}; give a path, socket://HOST:PORT or rfc2217://HOST:PORT"
            ) from err
        except (OSError, serial.SerialException) as err:
            raise NoSuchPort(
                f"nothing answers at {url} ({err}); start the server there, or correct the address"
            ) from err
        self._rate_set = self.rate = int(self._serial.baudrate)
        self._reader, self._writer = os.pipe()
        self._is_closed = threading.Event()
        self._failure = ""
        self._outgoing: queue.SimpleQueue[bytes | int | None] = queue.SimpleQueue()  # bytes, a rate, or the end
        self._threads = [
            threading.Thread(target=work, name=f"{what} {url}", daemon=True)
            for what, work in (("reader", self._pump), ("writer", self._send))
        ]
        for thread in self._threads:
            thread.start()

    def fileno(self) -> int:
        """Return the descriptor to wait on."""
        return self._reader

    def set_rate(self, rate: int) -> None:
        """Set the rate at the other end, before what is written next."""
        if rate != self._rate_set:
            self._rate_set = rate
            self._outgoing.put(rate)

    def write(self, data: bytes) -> None:
        """Send bytes; returns before they have left."""
        if self._failure or self._outgoing.qsize() >= MOST_WAITING:
            raise PortLost(f"{self.name} is gone: {self._failure or 'it takes no more bytes'}")
        self._outgoing.put(data)

    def close(self) -> None:
        """End the threads and close the port, after the last bytes have left or `CONNECT_TIMEOUT`."""
        if not self._is_closed.is_set():
            self._outgoing.put(None)
            self._threads[1].join(CONNECT_TIMEOUT)
            self._is_closed.set()
            self._threads[0].join()
            self._serial.close()
            os.close(self._reader)

    def _send(self) -> None:
        """Write what is queued, in its order."""
        try:
            while (item := self._outgoing.get()) is not None:
                if isinstance(item, int):
                    self._serial.baudrate = item
                else:
                    self._serial.write(item)
        except (OSError, ValueError, serial.SerialException) as err:
            self._failure = str(err) or type(err).__name__  # the pump ends, and the reader sees the end of the pipe

    def _pump(self) -> None:
        """Copy bytes until the port fails or is closed; the reader sees the end of the pipe."""
        try:
            while not (self._is_closed.is_set() or self._failure):
                data = self._serial.read(1)
                if data:
                    os.write(self._writer, data + self._serial.read(self._serial.in_waiting))
        except (OSError, serial.SerialException):
            pass  # the reader sees the end of the pipe
        finally:
            os.close(self._writer)


def _open_device(path: str) -> int:
    try:
        if stat.S_ISDIR(Path(path).stat().st_mode):
            raise _not_a_port(f"{path} is a directory")
        return os.open(path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
    except OSError as err:
        raise _explain(path, err.errno) from err


def _explain(path: str, code: int | None) -> GatewayError:
    match code:
        case errno.ENOENT | errno.ENODEV | errno.ENXIO | errno.EIO | errno.ENOTDIR:
            return NoSuchPort(
                f"there is no port {path}; plug the robot in, or start p2os-emu, and look at its name again"
            )
        case errno.EACCES | errno.EPERM:
            return GatewayError(f"you may not open {path}; {_permission_hint(path)}", ExitCode.NO_PERMISSION)
        case errno.EBUSY | errno.EWOULDBLOCK:
            return PortBusy(f"{path} is in use by another program; end that one first")
    reason = os.strerror(code) if code else "pyserial gives no reason"
    return _not_a_port(f"{path} cannot be opened as a serial port: {reason}")


def _not_a_port(why: str) -> GatewayError:
    return GatewayError(f"{why}; give the device that the robot is plugged into", ExitCode.NOT_A_PORT)


def _permission_hint(path: str) -> str:
    try:
        number = Path(path).stat().st_gid
    except OSError:
        return "a folder on the way to it is closed to you"
    try:
        group = grp.getgrgid(number).gr_name
    except KeyError:
        group = str(number)
    return f"it belongs to group {group}: sudo usermod -aG {group} $USER, then log in again"


def _address(url: str) -> tuple[str, int]:
    try:
        parts = urlsplit(url)
        host, port = parts.hostname, parts.port
    except ValueError as err:
        raise NoSuchPort(f"{url} is no address: {err}; write socket://HOST:PORT") from err
    if not host or port is None:
        raise NoSuchPort(f"{url} lacks a host or a port; write socket://HOST:PORT")
    return host, port

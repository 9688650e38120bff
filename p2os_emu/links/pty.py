"""A pseudo-terminal as the robot's serial port: the client opens the slave, the emulator holds the master.

A serial port on a real robot shows nothing when a client comes or goes, and loses what is sent while nobody has it
open. A pseudo-terminal hangs up when the last client closes it, and keeps unread bytes for whoever opens it next. So
the robot holds the slave open itself while nobody else does, and lets go of it while a client has it. Then:

- the master reports a hang-up exactly when the last client has left, without counting opens and closes;
- what that client left unread is discarded, and nothing piles up until the next one comes;
- a client that opens the port never meets a hung-up line (EIO ends some old drivers).

That a client has come is seen by its first bytes, or, when the robot has something to say, by letting go of the
slave for a moment: the master then hangs up only if nobody else is there (5 us).
"""

import os
import select
import socket
import termios
from hashlib import sha256
from pathlib import Path

from p2os_emu.links.link import Link, Outlet, PortError
from p2os_emu.links.poller import HUNG_UP, READABLE, Poller

_READ_SIZE = 4096
_SLAVE_FLAGS = os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK
_TERMINALS = "/dev/pts/"
# What Linux gives a serial port that nobody has set, and the host rate of these robots.
_FIRST_SPEED = termios.B9600
_SPEEDS = {
    getattr(termios, f"B{rate}"): rate
    for rate in (300, 600, 1200, 2400, 4800, 9600, 19200, 38400, 57600, 115200, 230400, 460800, 500000, 921600, 1000000)
}


class PtyLink(Link):
    """A robot on a pseudo-terminal.

    Args:
        poller: Tells this link when bytes have come or the client has left.
        path: Where to put a symbolic link that always leads to the port, also after it vanished and returned; None
            for none.
    Raises:
        PortError: Something that is not a leftover link to a terminal stands at `path`, another emulator has it, or the
            link cannot be made.
    """

    def __init__(self, poller: Poller, path: Path | None = None) -> None:
        super().__init__()
        self._poller = poller
        self._path = path
        self._outlet = Outlet()
        self._master: int | None = None
        self._held_slave: int | None = None
        self._claim = None if path is None else _claim(path)
        try:
            self.plug_in()
        except PortError:
            self.close()
            raise

    @property
    def attached(self) -> bool:
        """Whether a client is known to have the slave open."""
        return self._master is not None and self._held_slave is None

    @property
    def client_baud(self) -> int | None:
        """The speed set on the slave, bit/s; None for one without a standard number."""
        if self._master is None:
            return None
        # On Linux the master shows the slave's settings.
        output_speed: int = termios.tcgetattr(self._master)[5]
        return _SPEEDS.get(output_speed)

    def write(self, data: bytes) -> None:
        """Hand bytes to the client; nobody there loses them, a client that does not read loses whole frames."""
        if self._master is None or not (self.attached or self._somebody_came()):
            return
        if not self._outlet.write(self._master, data):
            self.dropped += 1

    def unplug(self) -> None:
        """Make the pseudo-terminal vanish: clients read end of file, the symbolic link is gone."""
        if self._master is None:
            return
        if self._path is not None and _leads_to(self._path, self._slave_name):
            self._path.unlink()
        self._poller.forget(self._master)
        os.close(self._master)
        self._master = None
        if self._held_slave is not None:
            os.close(self._held_slave)
            self._held_slave = None
        self.inbox.clear()
        self._outlet.clear()

    def plug_in(self) -> None:
        """Open a new pseudo-terminal, behind the same symbolic link.

        Raises:
            PortError: As for the constructor.
        """
        if self._master is not None:
            return
        if self._path is not None:
            _refuse_unless_replaceable(self._path)
        self._master, self._held_slave = os.openpty()
        os.set_blocking(self._master, False)
        self._slave_name = os.ttyname(self._held_slave)
        _make_raw(self._held_slave, _FIRST_SPEED)
        self._poller.watch(self._master, self._on_ready)
        if self._path is not None:
            try:
                _point(self._path, self._slave_name)
            except PortError:
                self.unplug()
                raise
        self.port = str(self._path or self._slave_name)

    def close(self) -> None:
        """Close the pseudo-terminal and remove the symbolic link."""
        self.unplug()
        if self._claim is not None:
            self._claim.close()

    def _on_ready(self, events: int) -> None:
        if events & READABLE:
            self._take_bytes()
        if events & HUNG_UP:
            self._hold_slave()
        elif not self.attached:
            # Bytes without a writer do not exist: somebody has it open, or had until a moment ago.
            self._somebody_came()

    def _take_bytes(self) -> None:
        assert self._master is not None
        try:
            self.inbox += os.read(self._master, _READ_SIZE)
        except OSError as error:
            # EIO: the last client left; EAGAIN: it flushed what it had sent.
            if not isinstance(error, BlockingIOError) and self.attached:
                self._hold_slave()

    def _somebody_came(self) -> bool:
        """Close the slave and check whether another process holds it."""
        assert self._master is not None
        if self._held_slave is not None:
            os.close(self._held_slave)
            self._held_slave = None
        probe = select.poll()
        probe.register(self._master, 0)
        if any(events & select.POLLHUP for _, events in probe.poll(0)):
            self._hold_slave()
        return self.attached

    def _hold_slave(self) -> None:
        """Nobody has the port open: hold it, and make it as a client may expect a fresh port to be."""
        assert self._master is not None
        if self._held_slave is not None:
            return
        try:
            self._held_slave = os.open(self._slave_name, _SLAVE_FLAGS)
        except OSError:
            # A client left its exclusive claim (TIOCEXCL) on the terminal: nobody can open this one any more.
            self.unplug()
            self.plug_in()
            return
        termios.tcflush(self._held_slave, termios.TCIFLUSH)
        self._outlet.clear()
        _make_raw(self._held_slave, termios.tcgetattr(self._held_slave)[5])


def _make_raw(descriptor: int, speed: int) -> None:
    """Eight bits, nothing translated, nothing echoed: an echo would come back to the robot as commands."""
    attributes = termios.tcgetattr(descriptor)
    attributes[0] = termios.IGNBRK
    attributes[1] = 0
    attributes[2] = termios.CS8 | termios.CREAD | termios.CLOCAL
    attributes[3] = 0
    attributes[4] = attributes[5] = speed
    attributes[6][termios.VMIN] = 1
    attributes[6][termios.VTIME] = 0
    termios.tcsetattr(descriptor, termios.TCSANOW, attributes)


def _claim(path: Path) -> socket.socket:
    """Take a path for this link alone: a leftover link looks like one in use, a name of the system's goes with us."""
    claim = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    place = path.parent.resolve() / path.name
    try:
        claim.bind("\0p2os-emu:" + sha256(bytes(place)).hexdigest())
    except OSError as error:
        claim.close()
        raise PortError(f"--pty {path} is in use by another emulator; choose another path") from error
    return claim


def _refuse_unless_replaceable(path: Path) -> None:
    if path.is_symlink():
        if not str(path.readlink()).startswith(_TERMINALS):
            raise PortError(
                f"--pty {path} is a link to {path.readlink()}, which is not a terminal; choose another path"
            )
    elif path.is_dir():
        raise PortError(f"--pty {path} is a directory; name a link to make in it, such as {path / 'robot'}")
    elif path.exists():
        raise PortError(f"--pty {path} exists and is not a link; remove it or choose another path")
    if not path.parent.is_dir():
        raise PortError(f"--pty {path}: there is no directory {path.parent}; make it first or choose another path")


def _point(path: Path, target: str) -> None:
    """Make or replace the symbolic link in one move, so that a client never finds none."""
    fresh = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        fresh.symlink_to(target)
        fresh.replace(path)
    except OSError as error:
        raise PortError(f"--pty {path} cannot be made: {error.strerror}; choose a path you may write to") from error


def _leads_to(path: Path, target: str) -> bool:
    return path.is_symlink() and str(path.readlink()) == target

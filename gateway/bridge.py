"""Joins one driver and one port, on one thread, and lets other threads command the driver.

The thread waits for bytes, for the driver's next deadline, or to be woken. A lock guards the driver; a command
from a thread of the bus writes its bytes to the port at once, so it does not wait for this thread.
"""

import os
import random
import select
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from contextlib import suppress
from math import inf
from typing import Generic, Protocol, TypeVar

from gateway.cables.cable import CableDriver
from gateway.errors import GatewayError, LineBlocked, PortLost
from gateway.events import (
    ElementFound,
    ElementLost,
    ElementSilent,
    Event,
    LinkLost,
    RobotRejected,
    SipReceived,
    SweepFailed,
)
from gateway.serial_port import READ_SIZE, Port, SocketPort

T = TypeVar("T")
D = TypeVar("D", bound=CableDriver)

REOPEN_PERIOD = 0.15
"""Seconds between two tries to open a port that is gone."""
LONGEST_BACKOFF = 2.0
"""Seconds at most between two connections that the other end closes before the robot was connected."""
REJECTED_PERIOD = 2.0
"""Seconds until a port is opened again behind which there was a robot that this gateway does not serve."""
BRAKING_TIME = 1.0
"""Seconds for a robot or an arm to stop before its motors are switched off on leaving."""
LONGEST_WAIT = 0.25
"""Seconds; often enough that the driver does not take an idle moment for a freeze, on a busy computer either."""

LOCK_PATIENCE = 0.5
"""Seconds for which a command waits for the bridge's thread: threads of the bus serve other robots as well. A driver
that was kept for so long begins again with STOP, and refuses commands."""
FLOOD_PAUSE = 0.01
"""Seconds until the next read from a port that fills a whole buffer at once: 400 kB/s are far above the fastest line,
and other robots of the process need the interpreter."""

SIGNS_OF_A_DEAD_LINE = (LinkLost, SweepFailed, ElementLost, ElementSilent)
SIGNS_OF_LIFE = (SipReceived, ElementFound)


def steady_clock() -> float:
    """Return the steady time, s; it includes sleep of the computer where the system has such a clock."""
    return time.clock_gettime(_CLOCK)


_CLOCK = getattr(time, "CLOCK_BOOTTIME", time.CLOCK_MONOTONIC)


class Backoff:
    """Pauses between attempts: each up to twice as long as the one before, shortened by up to a half at random."""

    def __init__(self, first: float, longest: float, rng: random.Random) -> None:
        """first, longest: of the pauses, s."""
        self._first = self._next = first
        self._longest = longest
        self._rng = rng

    def pause(self) -> float:
        """Return the pause before the next attempt, s."""
        pause = self._rng.uniform(0.5, 1.0) * self._next
        self._next = min(2.0 * self._next, self._longest)
        return pause

    def reset(self) -> None:
        """Begin with the first pause again, after a success."""
        self._next = self._first


class _BridgeListener(Protocol):
    """Receives the driver's events, on the bridge's thread."""

    def on_events(self, events: Sequence[Event], now: float, stamp_ns: int) -> None:
        """Take the driver's events, maybe none.

        Args:
            events: In their order.
            now: Steady time of the bridge, s.
            stamp_ns: Wall clock when the bytes were read that brought them about.
        """

    @property
    def deadline(self) -> float:
        """When the next call is due even without events, s."""


class Bridge(Generic[D]):
    """One driver on one port, which may be lost and opened again."""

    def __init__(
        self,
        driver: D,
        port: Port | None,
        reopen: Callable[[], Port],
        clock: Callable[[], float] = steady_clock,
        rng: random.Random | None = None,
    ) -> None:
        """Begin to talk: the first bytes leave before this returns.

        Args:
            driver: From now on called only through `command` and `post`.
            port: Open, and the bridge closes it; None begins by opening one.
            reopen: Opens it again after it was lost; raises GatewayError while it cannot.
            clock: Steady, s.
            rng: Of the pauses between connections.
        """
        self._driver = driver
        self._port = port
        self._reopen = reopen
        self._lost: PortLost | None = None
        self._lost_port: Port | None = None  # closed without the lock: a device may first wait for its last bytes
        self._why_not_open = ""
        self._reopen_at = -inf if port is None else inf
        self._clock = clock
        self._backoff = Backoff(REOPEN_PERIOD, LONGEST_BACKOFF, rng or random.Random())
        self._lock = threading.Lock()
        self._posted: deque[Callable[[D, float], object]] = deque()
        self._wake_reader, self._wake_writer = os.pipe()
        self._waking = threading.RLock()  # a signal handler may wake while its own thread is waking
        os.set_blocking(self._wake_writer, False)
        os.set_blocking(self._wake_reader, False)
        self._waits_until = -inf
        self._is_stopped = self._is_closed = self._is_blocked = False
        if port is not None:
            with self._lock:
                driver.port_opened(clock())
                self._flush()

    def command(self, call: Callable[[D, float], T], patience: float = LOCK_PATIENCE) -> T:
        """Call a function with the driver from any thread; the bytes due are written before this returns.

        Args:
            call: Called with the driver and the steady time, under the lock; what it raises comes through.
            patience: s to wait for the lock.
        Raises:
            LineBlocked: The bridge's thread hangs in its port, so the function was not called.
        """
        if not self._lock.acquire(timeout=0.0 if self._is_blocked else patience):
            self._is_blocked = True
            raise LineBlocked("the port hangs; the command was not sent")
        try:
            self._is_blocked = False
            try:
                return call(self._driver, self._clock())
            finally:
                self._flush()
                if self._driver.deadline < self._waits_until:
                    self.wake()
        finally:
            self._lock.release()

    def post(self, call: Callable[[D, float], object]) -> None:
        """Call a function with the driver without waiting: now if the lock is free, else on the bridge's thread.

        Args:
            call: As for `command`; must not raise.
        """
        self._posted.append(call)
        if self._lock.acquire(blocking=False):
            try:
                self._run_posted()
                self._flush()
            finally:
                self._lock.release()
        self.wake()

    def run(self, listener: _BridgeListener) -> None:
        """Work until `stop`."""
        while not self._is_stopped:
            has_bytes = self._wait(listener.deadline)
            if self._port is None and self._clock() >= self._reopen_at:
                self._open_again()
            with self._lock:
                self._run_posted()
                now = self._clock()
                data = self._read() if has_bytes else b""
                stamp_ns = time.time_ns()
                events = self._work(data, now)
            self._close_lost_port()
            self._is_blocked = False
            listener.on_events(events, now, stamp_ns)
            if len(data) == READ_SIZE:
                time.sleep(FLOOD_PAUSE)

    def stop(self) -> None:
        """Let `run` return; from any thread or signal handler."""
        self._is_stopped = True
        self.wake()

    def _close_lost_port(self) -> None:
        if self._lost_port is not None:
            self._lost_port.close()
            self._lost_port = None

    def close(self) -> None:
        """Stop what moves, write the closing bytes and close the port."""
        with self._lock:
            if self._port is not None:
                with suppress(PortLost):  # the other end may be gone
                    self._port.write(self._driver.stopping_bytes)
                    self._let_it_brake(self._port)
                    self._port.write(self._driver.closing_bytes)
                self._port.close()
                self._port = None
        with self._waking:
            if not self._is_closed:
                self._is_closed = True
                os.close(self._wake_reader)
                os.close(self._wake_writer)

    def _run_posted(self) -> None:
        while self._posted:
            self._posted.popleft()(self._driver, self._clock())

    def _let_it_brake(self, port: Port) -> None:
        """Wait for what moves to stop: the last words may take the power off its motors."""
        until = self._clock() + BRAKING_TIME
        while self._driver.is_moving and (left := until - self._clock()) > 0.0:
            if select.select([port], (), (), left)[0]:
                self._driver.receive(port.read(), self._clock())

    def _wait(self, listener_deadline: float) -> bool:
        """Wait for something to do; return whether bytes have arrived."""
        with self._lock:
            port = self._port
            deadline = min(self._driver.deadline, self._reopen_at, listener_deadline)
            now = self._clock()
            self._waits_until = min(deadline, now + LONGEST_WAIT)
            timeout = max(0.0, self._waits_until - now)
        watched: list[Port | int] = [self._wake_reader] if port is None else [self._wake_reader, port]
        ready, _, _ = select.select(watched, (), (), timeout)
        if self._wake_reader in ready:
            os.read(self._wake_reader, 64)
        return port is not None and port in ready

    def _read(self) -> bytes:
        try:
            return b"" if self._port is None else self._port.read()
        except PortLost as lost:
            self._lost = lost
            return b""

    def _work(self, data: bytes, now: float) -> list[Event]:
        if self._lost is not None:
            self._lose_port(self._lost, now)
            self._reopen_at = now + self._backoff.pause()
        events = self._driver.receive(data, now)
        if any(isinstance(event, SIGNS_OF_LIFE) for event in events):
            self._backoff.reset()
        if isinstance(self._port, SocketPort) and any(isinstance(e, SIGNS_OF_A_DEAD_LINE) for e in events):
            # A dead connection gives no sign, and one that revives would bring old bytes.
            self._lose_port(PortLost("the connection is dead"), now)
        self._flush()
        if self._port is not None and any(isinstance(event, RobotRejected) for event in events):
            # Another program may need the port; it is opened again later.
            self._lose_port(PortLost("another robot is there"), now)
            self._reopen_at = now + REJECTED_PERIOD
        return events

    def _flush(self) -> None:
        """Write what is due now. A port that fails is closed by the bridge's own thread, which may be waiting on it."""
        data = self._driver.bytes_due(self._clock())
        if not data or self._port is None or self._lost is not None:
            return
        try:
            if self._driver.baud:
                self._port.set_rate(self._driver.baud)
            self._port.write(data)
        except PortLost as lost:
            self._lost = lost
            self.wake()

    def _open_again(self) -> None:
        """Try to open the port; without the lock, since a connection may fail slowly."""
        try:
            port = self._reopen()
        except GatewayError as error:  # it is not back yet
            self._reopen_at = self._clock() + REOPEN_PERIOD
            if str(error) != self._why_not_open:
                self._why_not_open = str(error)
                with self._lock:
                    self._driver.port_lost(self._why_not_open, self._clock())
            return
        self._why_not_open = ""
        with self._lock:
            self._reopen_at = inf
            self._port = port
            self._driver.port_opened(self._clock())
            self._flush()

    def _lose_port(self, lost: PortLost, now: float) -> None:
        self._lost_port = self._port
        self._port = self._lost = None
        self._reopen_at = now + REOPEN_PERIOD
        self._driver.port_lost(str(lost), now)

    def wake(self) -> None:
        """Let `run` look after everything now; from any thread or signal handler, and after `close` as well."""
        with self._waking:
            if self._is_closed:
                return  # the descriptor may be in other use by now
            with suppress(BlockingIOError):  # it is being woken already
                os.write(self._wake_writer, b"!")

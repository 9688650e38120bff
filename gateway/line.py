"""The kind of line to the robot: a cable or a pair of radio modems, which must be dialled."""

from dataclasses import dataclass

DIAL = b"WMS2\r"
"""Dials the other modem. Source: client libraries."""
DIALLED = b"onnected to address"
"""The modem reports that it has found the other one; the case of the first letter differs. Source: client libraries."""
FIRST_DIAL_TIMEOUT = 1.0
LONGEST_DIAL_TIMEOUT = 4.0
"""Seconds to wait for that report, at first and after many failures."""
RADIO_BAUD = 9600
"""bit/s, the only rate of radio modems: a robot behind them must never be told to raise its own."""


@dataclass(frozen=True, slots=True)
class LineKind:
    """A kind of line; times in s.

    first_window, last_window: for the answer to a SYNC, at first and after some silent sweeps. step_window: for each
    further answer of a robot that has begun to answer. settling: by which a silence may shrink on its way to the robot.
    first_backoff, last_backoff: longest pause after a sweep, at first and after many. sip_timeout: time without a SIP
    after which the robot is lost; below the 2 s of its watchdog, so that STOP arrives before the robot can resume
    anything. share: part of the line's bytes to the robot that may be used. streams: the robot may send more packets
    than SIPs in every cycle; else it is asked for one at a time, every `poll_period`. baud: bit/s that the line
    carries, whatever the port is set to; 0 for the port's rate. accessory_delay: by which the answer of an accessory
    may come later than on a cable. dial: bytes to write before the robot can receive.
    """

    first_window: float
    last_window: float
    step_window: float
    settling: float
    first_backoff: float
    last_backoff: float
    sip_timeout: float
    share: float = 1.0
    streams: bool = True
    poll_period: float = 2.0
    baud: int = 0
    accessory_delay: float = 0.0
    dial: bytes = b""


# A robot answers within 50 ms, and 12 bytes take 12.5 ms at 9600 bit/s.
CABLE = LineKind(
    first_window=0.08,
    last_window=0.25,
    step_window=0.25,
    settling=0.01,
    first_backoff=0.2,
    last_backoff=0.2,
    sip_timeout=1.0,
)
# Modems add their own delay both ways, which nothing public states: a quarter of a second is assumed at most. SIPs of a
# robot with many sonar discs take 70 % of 9600 bit/s; a quarter of the line is left to commands, should the two ends
# have to take turns. A request of three frames takes half a second on that quarter, and its answer waits for SIPs.
RADIO = LineKind(
    first_window=0.4,
    last_window=0.8,
    step_window=0.6,
    settling=0.1,
    first_backoff=0.5,
    last_backoff=4.0,
    sip_timeout=1.5,
    share=0.25,
    streams=False,
    baud=RADIO_BAUD,
    accessory_delay=1.5,
    dial=DIAL,
)


class ModemDialler:
    """Dials a radio modem, as the clients of these robots do.

    The modem repeats what it receives, and reports when it has found the other one. One that reports nothing may be
    connected all the same: the dial string then reaches the robot, which ignores it. So the robot is tried in any case.

    frame: the dial string. has_answered: since `begin`. timeout: for the report, s.
    """

    def __init__(self, frame: bytes) -> None:
        """frame: the dial string."""
        self.frame = frame
        self.has_answered = False
        self.timeout = FIRST_DIAL_TIMEOUT
        self._received = b""

    def begin(self) -> None:
        """Forget earlier reports: the dial string is written now."""
        self.has_answered = False
        self._received = b""

    def receive(self, data: bytes) -> None:
        """Take bytes from the line."""
        self._received = (self._received + data)[-len(DIALLED) - len(data) :]
        if DIALLED in self._received:
            self.has_answered = True
            self.timeout = FIRST_DIAL_TIMEOUT

    def give_up(self) -> None:
        """Double the timeout of the next attempt: no report came."""
        self.timeout = min(2.0 * self.timeout, LONGEST_DIAL_TIMEOUT)

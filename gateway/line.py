"""What kind of line leads to the robot: how long an answer takes, and how much it carries."""

from dataclasses import dataclass

DIAL = b"WMS2\r"
"""Dials a radio modem's partner. Source: client libraries."""
RADIO_BAUD = 9600
"""bit/s; radio modems know no other, so a robot behind them must never be told to raise its own."""


@dataclass(frozen=True, slots=True)
class LineKind:
    """A kind of line; times in s.

    first_window, last_window: for the answer to a SYNC, at first and after some silent sweeps. step_window: for each
    further answer of a robot that has begun to answer. settling: by which silence may shrink on its way to the robot.
    first_backoff, last_backoff: longest pause after a sweep, at first and after many. sip_timeout: without a SIP,
    after which the robot is lost; below its watchdog's 2 s, so that it is told STOP before it can resume anything.
    share: of the line's bytes to the robot that may be used. streams: the robot may be asked for more packets than
    SIPs in every cycle; else one at a time, every `poll_period`. baud: bit/s that it carries, whatever the port is set
    to; 0 where the port's rate says it. detour: by which the answer of what hangs on the robot may come later than on
    a cable. dial: what to say to the line before the robot hears.
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
    detour: float = 0.0
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
    detour=1.5,
    dial=DIAL,
)

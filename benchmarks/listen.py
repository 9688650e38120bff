"""Listens to many robots and lasers at once, as their hosts would."""

import select
import time
from collections.abc import Sequence

from benchmarks.client import PortClient
from benchmarks.laser_client import LaserPortClient
from p2os import Command
from p2os.sip import SIP_TYPES

KEEP_ALIVE_S = 1.0


def listen(clients: Sequence[PortClient], lasers: Sequence[LaserPortClient], seconds: float) -> list[list[float]]:
    """Read everybody as bytes come and keep the robots alive.

    Returns:
        Arrival times of each robot's SIPs, s on the steady clock.
    """
    arrivals: list[list[float]] = [[] for _ in clients]
    owner = {client.descriptor: number for number, client in enumerate(clients)}
    scanner = {laser.descriptor: laser for laser in lasers}
    deadline, pulse_due = time.monotonic() + seconds, 0.0
    while (now := time.monotonic()) < deadline:
        if now >= pulse_due:
            pulse_due = now + KEEP_ALIVE_S
            for client in clients:
                client.send(Command.PULSE)
        ready = select.select([*owner, *scanner], [], [], KEEP_ALIVE_S)[0]
        for descriptor in sorted(ready, key=scanner.__contains__):  # SIPs first: their times are what is measured
            if descriptor in scanner:
                scanner[descriptor].read()
                continue
            number = owner[descriptor]
            arrivals[number].extend(at for at, payload in clients[number].read() if payload[0] in SIP_TYPES)
    return arrivals

"""One session of the soak benchmark: joins the bus, uses a robot as a program does, and leaves."""

import contextlib
import os
import signal
import threading
from enum import Enum

from bus import Refused, Sample, ZenohBus, keys
from bus.messages import twist

PATIENCE_S = 10.0


class Leaving(Enum):
    """How a session ends."""

    CLOSED = "closed"
    KILLED = "killed"
    FROZEN = "frozen"  # until it is killed


def visit(robot: str, number: int, leaving: Leaving) -> None:
    """Join, subscribe to everything, query, take and use a lease, and leave; runs in a process of its own."""
    heard = threading.Event()

    def hear(sample: Sample) -> None:
        heard.set()

    bus = ZenohBus.open()
    name = f"soak-visitor-{number}"
    bus.subscribe(f"{robot}/**", hear)
    bus.watch_alive("**", lambda key, is_alive: None)
    bus.declare_alive(f"{name}/alive")
    bus.serve(f"{name}/description", lambda given: {})
    if not heard.wait(PATIENCE_S):
        raise TimeoutError(f"session {number} heard nothing of {robot} for {PATIENCE_S:g} s")
    bus.query(keys.DESCRIPTION.key(robot))
    with contextlib.suppress(Refused):  # a session that was killed or frozen before still holds the lease
        token = bus.query(keys.LEASE.key(robot), {"do": "take", "holder": name, "seconds": 1.0})[0].value["token"]
        bus.put(keys.CMD_VEL.key(robot), twist(0.0, 0.1), attachment=token.encode())
        bus.query(keys.LEASE.key(robot), {"do": "release", "token": token})
    match leaving:
        case Leaving.CLOSED:
            bus.close()
        case Leaving.KILLED:
            os.kill(os.getpid(), signal.SIGKILL)
        case Leaving.FROZEN:
            os.kill(os.getpid(), signal.SIGSTOP)

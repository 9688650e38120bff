"""Heartbeats: a program shows several times a second that it still works.

A robot's gateway binds a motion to the heartbeat that the command names, and stops the motion when the heartbeat stops.
A liveliness token disappears only when the link to a program is lost; a heartbeat also stops when the program freezes.
It is a sample on a key of the commanding program that ends in `/heartbeat`; the payload is ignored.
"""

import logging
import threading

from bus.bus import JSON, Bus, Subscription
from bus.errors import BusError, KeyNotValid
from bus.exchange import plain_key

SUFFIX = "/heartbeat"
PERIOD = 0.1
"""Seconds between two beats."""
LONGEST_PERIOD = 0.25
"""Seconds between two beats of a foreign program, at most: one that is lost does no harm."""
SILENCE = 0.5
"""Seconds without a beat after which the commander counts as dead or frozen."""

log = logging.getLogger("bus")


def heartbeat_key(text: str) -> str:
    """Return a key, after checking that it can be that of a heartbeat.

    Raises:
        KeyNotValid: It has wildcards, is malformed, has a part that begins with @, or does not end in `/heartbeat`.
    """
    if not text.endswith(SUFFIX):
        raise KeyNotValid(f"{text!r} is not the key of a heartbeat; it must end in {SUFFIX}")
    if any(part.startswith("@") for part in text.split("/")):
        raise KeyNotValid(f"{text!r} is not the key of a heartbeat; parts that begin with @ are Zenoh's own")
    try:
        return plain_key(text)
    except KeyNotValid as err:
        raise KeyNotValid(f"{text!r} is not the key of a heartbeat: {err}") from err


class Heartbeat(Subscription):
    """Publishes a heartbeat from a thread of its own until it is closed, for a program without an event loop.

    key: for the commands that are bound to the heartbeat.
    """

    def __init__(self, bus: Bus, key: str) -> None:
        """Start at once.

        Args:
            bus: The bus; is closed after this.
            key: Ends in `/heartbeat`; no other program publishes on it.
        Raises:
            KeyNotValid: The key is not that of a heartbeat.
        """
        self.key = heartbeat_key(key)
        self._publisher = bus.publisher(key, JSON)
        self._is_closed = threading.Event()
        self._thread = threading.Thread(target=self._run, name=f"heartbeat {key}", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stop the heartbeat; motions that are still bound to it stop."""
        self._is_closed.set()
        self._thread.join()
        self._publisher.close()

    def _run(self) -> None:
        while True:
            try:
                self._publisher.put({})
            except BusError as err:  # the bus is closed before this: the motions stop, as they do at a close
                log.debug("the heartbeat on %s ends: %s", self.key, err)
                return
            if self._is_closed.wait(PERIOD):
                return

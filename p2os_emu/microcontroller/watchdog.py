"""The watchdog: a robot whose client has fallen silent stops, and remembers where it was going."""


class ClientWatchdog:
    """Counts the silence of the client.

    barking: no valid packet for `timeout` seconds; the wheels stand until one comes. A timeout of zero never barks.
    """

    __slots__ = ("_silence", "barking", "timeout")

    def __init__(self, timeout: float) -> None:
        self.timeout = timeout
        self.barking = False
        self._silence = 0.0

    def feed(self) -> None:
        """A valid packet came."""
        self._silence = 0.0
        self.barking = False

    def advance(self, dt: float) -> None:
        """Let time pass."""
        self._silence += dt
        if self._silence >= self.timeout > 0.0:
            self.barking = True

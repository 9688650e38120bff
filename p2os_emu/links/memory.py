"""A port in memory, for tests and for lockstep: both ends in one process."""

from p2os_emu.links.link import Link


class MemoryLink(Link):
    """A link whose client calls `client_write` and `client_read` in the same process.

    client_rate: bit/s the client pretends to have set; None for a port that knows no rate.
    """

    def __init__(self, port: str = "memory", *, client_rate: int | None = None) -> None:
        super().__init__()
        self.port = port
        self.client_rate = client_rate
        self._plugged = True
        self._to_client: list[bytes] = []

    @property
    def attached(self) -> bool:
        """Always, until unplugged: the client lives in this process."""
        return self._plugged

    @property
    def client_baud(self) -> int | None:
        """The rate the client pretends to have set, bit/s."""
        return self.client_rate

    def write(self, data: bytes) -> None:
        """Keep the bytes until the client reads them."""
        if self._plugged:
            self._to_client.append(data)

    def unplug(self) -> None:
        """Drop the bytes in transit and carry nothing more."""
        self._plugged = False
        self.inbox.clear()
        self._to_client.clear()

    def plug_in(self) -> None:
        """Carry bytes again."""
        self._plugged = True

    def close(self) -> None:
        """As `unplug`."""
        self.unplug()

    def client_write(self, data: bytes) -> None:
        """The client's side: send bytes to the robot."""
        if self._plugged:
            self.inbox += data

    def client_read(self) -> bytes:
        """The client's side: take everything the robot has sent since the last read."""
        return b"".join(self.client_read_pieces())

    def client_read_pieces(self) -> list[bytes]:
        """The client's side: as `client_read`, one item for each write of the robot."""
        pieces = list(self._to_client)
        self._to_client.clear()
        return pieces

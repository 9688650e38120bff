"""A server of the protocol of ACTS: existing clients get the blobs of the newest image over TCP.

Source: the accessories sheet, section 4.
"""

import asyncio
from collections.abc import Awaitable, Callable
from contextlib import suppress

from agents.wrappers.acts import REQUESTS
from bus import Refused

MOST_CLIENTS = 16
READING_TIME = 5.0
"""Seconds that a client may take to read a reply before its connection is closed."""


class ActsServer:
    """Serves from `start` until `close`."""

    def __init__(self, reply: Callable[[], Awaitable[bytes]]) -> None:
        """Prepare one.

        Args:
            reply: Returns header and blobs of the newest image.
        """
        self._reply = reply
        self._server: asyncio.Server | None = None
        self._clients: set[asyncio.Task[None]] = set()

    @property
    def has_clients(self) -> bool:
        """Whether a client is connected; any thread."""
        return bool(self._clients)

    @property
    def port(self) -> int | None:
        """The TCP port; None while it does not serve."""
        return self._server.sockets[0].getsockname()[1] if self._server else None

    async def start(self, host: str, port: int) -> None:
        """Listen at an address; a server that listened before is closed.

        Raises:
            Refused: The address cannot be used.
        """
        await self.close()
        try:
            self._server = await asyncio.start_server(self._serve, host, port)
        except OSError as err:
            raise Refused(f"clients of ACTS cannot be served on {host}:{port}: {err}; give another port") from err

    async def close(self) -> None:
        """End all connections and listen no more."""
        if self._server is not None:
            self._server.close()
            self._server = None
        ending = list(self._clients)
        for client in ending:
            client.cancel()
        await asyncio.gather(*ending, return_exceptions=True)  # each ends as cancelled

    async def _serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        task = asyncio.current_task()
        assert task is not None
        if len(self._clients) >= MOST_CLIENTS:
            writer.close()
            return
        self._clients.add(task)
        try:
            with suppress(OSError, TimeoutError):  # the client has gone, or reads nothing
                await self._answer(reader, writer)
        finally:
            self._clients.discard(task)
            writer.transport.abort()  # what a client has not read it does not get

    async def _answer(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Answer requests until the client ends, or quits: the server serves others, so it ends the connection only."""
        while (asked := await reader.read(1)) not in (b"", REQUESTS["quit"]):
            if asked == REQUESTS["blobs"]:
                writer.write(await self._reply())
                async with asyncio.timeout(READING_TIME):
                    await writer.drain()

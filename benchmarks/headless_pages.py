"""Pages of the console without a browser, for many tabs on a small machine: `python -m benchmarks.headless_pages`.

Each loads a page with a map, connects as NiceGUI's script does, so that the console refreshes the page, and requests
updates of the map one after the other. It draws nothing: twenty browsers that draw with the processor would measure
the machine, and not the console. It prints one line of JSON: by page, the ages of readings when they came, ms.
"""

import asyncio
import json
import re
import sys
import time
import urllib.request
import uuid
from contextlib import suppress

from websockets.asyncio.client import ClientConnection, connect

from apps.console.map_layers import HEADER
from apps.web.viewer import LENGTH

FRAME = 1 / 60  # s that a browser takes until it requests the next update
_SOCKET = "/_nicegui_ws/socket.io/?EIO=4&transport=websocket&implicit_handshake=true&next_message_id=0"


def stamps_of(reply: bytes) -> dict[str, float]:
    """Return when the poses in an update of the map were measured, s since 1970, by robot."""
    (length,) = LENGTH.unpack_from(reply)
    head = json.loads(reply[LENGTH.size : LENGTH.size + length])
    live = reply[LENGTH.size + length :][: head["live"]]
    found, at = {}, 0
    while at < len(live):
        number, _, discs, beams, stamp, *_ = HEADER.unpack_from(live, at)
        found[head["names"][number]] = stamp
        at += HEADER.size + 2 * (discs + beams)
        at += -at % 8
    return found


async def _page(url: str, settle: float, seconds: float) -> list[float]:
    """Show a page for some time; returns the ages of all readings that came after the first `settle` s, ms."""
    text = await asyncio.to_thread(lambda: urllib.request.urlopen(url, timeout=60).read().decode())
    ticket, client = re.search(r"/map/([\w-]{10,})", text), re.search(r"[\"']client_id[\"']:\s*[\"']([\w-]+)", text)
    if ticket is None or client is None:
        raise ValueError("the page has no map, or NiceGUI names its client in another way")
    where = url.rstrip("/").replace("http", "ws", 1)
    who = f"client_id={client[1]}&tab_id={uuid.uuid4()}&document_id={uuid.uuid4()}"
    ages: list[float] = []
    async with connect(f"{where}{_SOCKET}&{who}", max_size=None) as socket, connect(f"{where}/map/{ticket[1]}") as map_:
        await socket.recv()
        await socket.send("40")
        alive = asyncio.ensure_future(_answer_pings(socket))
        begun, last = time.monotonic(), dict[str, float]()
        while time.monotonic() - begun < settle + seconds:
            await map_.send("next")
            stamps = stamps_of(await map_.recv(decode=False))
            now = time.time()
            new = {name: stamp for name, stamp in stamps.items() if last.get(name) != stamp}
            if time.monotonic() - begun > settle:
                ages += [(now - stamp) * 1e3 for stamp in new.values()]
            last |= new
            await asyncio.sleep(FRAME)
        if alive.done():
            raise ConnectionError(f"the console has ended a page: {alive.exception()}")
        alive.cancel()
        with suppress(asyncio.CancelledError):  # as it is to end
            await alive
    return ages


async def _answer_pings(socket: ClientConnection) -> None:
    """Take what the console sends to a page, and answer the pings of Engine.IO."""
    async for message in socket:
        if message == "2":
            await socket.send("3")


async def _pages(url: str, count: int, settle: float, seconds: float) -> None:
    print(json.dumps(await asyncio.gather(*(_page(url, settle, seconds) for _ in range(count)))))


if __name__ == "__main__":
    asyncio.run(_pages(sys.argv[1], int(sys.argv[2]), float(sys.argv[3]), float(sys.argv[4])))

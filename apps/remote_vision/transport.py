"""Images to browsers over websockets.

The browser requests each image after it has drawn the one before (`apps/web/viewer.py`), and gets the newest one
there is, as it came from the camera.
"""

import asyncio
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from typing import Any

from starlette.websockets import WebSocket, WebSocketDisconnect

from agents.platform import AgentName
from apps.remote_vision.settings import ImageTimes
from apps.remote_vision.streams import NewestItem, SharedStreams, StreamItem
from apps.remote_vision.viewing import ORIGINAL, RESULT, VISION, Viewing, boxes
from apps.web.viewer import framed

UNKNOWN_TICKET = 4404
"""Code with which a websocket is closed whose page this program does not know."""

_Sent = tuple[NewestItem | None, int]
"""The stream of the last image that was sent, and the image's number in it; a stream that ended begins anew from 1."""
Words = Callable[[Viewing, str, float], str]
"""Returns why a place of a viewing has no new image, after so many s."""


class ImageTransport:
    """Serves the images of all viewings."""

    def __init__(
        self,
        streams: SharedStreams,
        viewings: Mapping[str, Viewing],
        times: ImageTimes,
        words: Words,
        wall_time: Callable[[], float],
    ) -> None:
        """Prepare it.

        Args:
            streams: Of the images.
            viewings: By ticket.
            times: Settings.
            words: Explains silence.
            wall_time: The bus's clock, s since 1970, by which images are stamped.
        """
        self._streams = streams
        self._viewings = viewings
        self._times = times
        self._words = words
        self._wall_time = wall_time

    async def serve(self, socket: WebSocket, ticket: str, place: str) -> None:
        """Answer the requests of one websocket until it ends.

        Args:
            socket: Not accepted yet.
            ticket: Of the viewing.
            place: `original` or `result`.
        """
        await socket.accept()
        viewing = self._viewings.get(ticket)
        if viewing is None:
            await socket.close(UNKNOWN_TICKET)
            return
        sent: _Sent = (None, 0)
        viewing.sockets += place == ORIGINAL
        with self._following(viewing, place) as following:
            try:
                while True:
                    await socket.receive_text()
                    if place == ORIGINAL:
                        viewing.seen_at = asyncio.get_running_loop().time()
                    head, item, sent = await self._reply(viewing, place, following(), sent)
                    await socket.send_bytes(framed(head, item.image if item is not None else b""))
            except (WebSocketDisconnect, RuntimeError):  # RuntimeError: it has been closed while an image was awaited
                return
            finally:
                viewing.sockets -= place == ORIGINAL

    async def _reply(
        self, viewing: Viewing, place: str, streams: list[NewestItem], sent: _Sent
    ) -> tuple[dict[str, Any], StreamItem | None, _Sent]:
        """Wait for a newer image; return the head of the reply, the item, and what has been sent by then."""
        begun = asyncio.get_running_loop().time()
        item = None
        if streams:
            stream, *others = streams
            than = sent[1] if sent[0] is stream else 0
            item = await stream.newer(than, self._times.wait_s)
        else:
            await asyncio.sleep(self._times.wait_s)
        head: dict[str, Any] = {"waited": round(asyncio.get_running_loop().time() - begun, 4), "words": ""}
        if item is None:
            head["is_empty"] = not streams
            if streams:
                reason = _result_trouble(stream.key, others) if place == RESULT else ""
                head["words"] = reason or self._words(viewing, place, stream.silence)
            return head, None, sent
        if len(item.image) > self._times.most_bytes:
            size, most = len(item.image) / 1e6, self._times.most_bytes / 1e6
            head["words"] = f"an image of {size:.1f} MB is not sent; at most {most:.1f} MB"
            return head, None, (stream, item.number)
        viewing.shown[place] = item
        head |= {"number": item.number, "format": item.format, "words": item.trouble}
        if item.stamp is not None:
            head |= {"stamp": item.stamp, "age": round(self._wall_time() - item.stamp, 4)}
        if item.values is not None:
            head["numbers"] = item.values.get("numbers")
        if place == ORIGINAL:
            head["words"] = item.trouble or _overlay_trouble(others)
            head["boxes"] = [
                box for other in others if other.item for box in boxes(_source(other.key), other.item.values)
            ]
        return head, item, (stream, item.number)

    @contextmanager
    def _following(self, viewing: Viewing, place: str) -> Iterator[Callable[[], list[NewestItem]]]:
        """Give a function that returns the streams of a place: its image first, then overlays. They may change."""
        open_now: dict[str, ExitStack] = {}
        streams: dict[str, NewestItem] = {}

        def current() -> list[NewestItem]:
            wanted = _wanted_keys(viewing, place)
            for key in set(open_now) - set(wanted):
                open_now.pop(key).close()
                del streams[key]
            for key in wanted:
                if key not in open_now:
                    open_now[key] = ExitStack()
                    streams[key] = open_now[key].enter_context(self._streams.following(key))
            return [streams[key] for key in wanted]

        try:
            yield current
        finally:
            for each in open_now.values():
                each.close()


def _wanted_keys(viewing: Viewing, place: str) -> list[str]:
    """Return the keys that a place needs: that of its image first, then those of overlays or of the vision agent."""
    if not (key := viewing.keys.get(place)):
        return []
    beside = sorted(viewing.overlays) if place == ORIGINAL else [VISION]
    return [key, *(AgentName(agent, viewing.robot).results_key for agent in beside)]


def _overlay_trouble(streams: Sequence[NewestItem]) -> str:
    """Return what an agent whose blobs are drawn reports of the image; empty for nothing."""
    for stream in streams:
        if stream.item is not None and stream.item.trouble:
            return f"{_source(stream.key)}: {stream.item.trouble}"
    return ""


def _result_trouble(key: str, streams: Sequence[NewestItem]) -> str:
    """Return what the vision agent reports of the stream of a result; empty for nothing."""
    for stream in streams:
        values = stream.item.values if stream.item is not None else None
        match values:
            case {"streams": dict(troubles)} if isinstance(troubles.get(key), str):
                return str(troubles[key])
    return ""


def _source(key: str) -> str:
    return key.split("/")[-2]

"""An IP camera's HTTP server: MJPEG on `/video`, one picture on `/image`, a page on `/`.

Each part of the stream tells when its picture was taken, `X-Timestamp` in s since 1970, as mjpg-streamer does.
"""

import socket
import sys
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

from p2os_emu.camera.feed import Feed

BOUNDARY = "picture"
PATIENCE = 10.0
"""Seconds that a viewer may take to read a picture, and that one may take to come."""
SEND_BUFFER = 2**16
"""Bytes that may wait on the way to a viewer: few, so that a slow one sees new pictures, not old ones."""

PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>{title}</title></head>
<body><h1>{title}</h1><p>An emulated camera. <a href="/video">/video</a> is a stream of JPEG pictures
(multipart/x-mixed-replace), <a href="/image">/image</a> a single one.</p><img src="/video" alt="what it sees"></body>
</html>
"""


class CameraServer(ThreadingHTTPServer):
    """Serves one feed on a listening socket."""

    daemon_threads = True

    def __init__(self, listener: socket.socket, feed: Feed, title: str) -> None:
        super().__init__(listener.getsockname(), _Handler, bind_and_activate=False)
        self.socket.close()
        self.socket = listener
        self.feed = feed
        self.title = title

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Ignore viewers that disconnect or do not read while a picture is sent."""
        if not isinstance(sys.exception(), ConnectionError | TimeoutError):
            super().handle_error(request, client_address)


class _Handler(BaseHTTPRequestHandler):
    timeout = PATIENCE
    server: CameraServer

    def do_GET(self) -> None:
        """Answer one request."""
        match self.path.partition("?")[0]:
            case "/":
                self._send("text/html; charset=utf-8", PAGE.format(title=self.server.title).encode())
            case "/image":
                self._send_picture()
            case "/video":
                self._send_video()
            case _:
                self.send_error(HTTPStatus.NOT_FOUND, "there are /, /image and /video")

    def log_message(self, *args: object) -> None:
        """Log nothing about viewers."""

    def _send(self, kind: str, body: bytes) -> None:
        self.send_response(HTTPStatus.OK)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(body)))
        self.send_header("Cache-Control", "no-store")
        self.end_headers()
        self.wfile.write(body)

    def _send_picture(self) -> None:
        feed = self.server.feed
        with feed.watching() as before:
            picture = feed.after(before, PATIENCE)
        if picture is None:
            self.send_error(HTTPStatus.SERVICE_UNAVAILABLE, "no picture has come")
        else:
            self._send("image/jpeg", picture.jpeg)

    def _send_video(self) -> None:
        self.connection.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, SEND_BUFFER)
        self.send_response(HTTPStatus.OK)
        self.send_header("Content-Type", f"multipart/x-mixed-replace; boundary={BOUNDARY}")
        self.send_header("Cache-Control", "no-store")
        self.end_headers()
        feed = self.server.feed
        with feed.watching() as number:
            while (picture := feed.after(number, PATIENCE)) is not None:
                number = picture.number
                head = (
                    f"--{BOUNDARY}\r\nContent-Type: image/jpeg\r\nContent-Length: {len(picture.jpeg)}\r\n"
                    f"X-Timestamp: {picture.time:.6f}\r\n\r\n"
                )
                self.wfile.write(head.encode() + picture.jpeg + b"\r\n")

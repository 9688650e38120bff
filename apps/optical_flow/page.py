"""The live page of a drive: image, flow and time to contact, the situation in words, and a button that ends the drive.

A thread with an event loop of its own serves it. It draws what the drive has shown last, when a browser requests it, so
neither a browser that is slow nor one that freezes holds up the drive. The page begins no motion, and does not count as
a sign of life of the drive.
"""

import asyncio
import math
import socket
import threading
import time
from typing import Any

import numpy as np
import uvicorn
from fastapi import FastAPI
from nicegui import ui
from starlette.websockets import WebSocket, WebSocketDisconnect

from agents.platform.errors import in_words
from apps.optical_flow.film import FlowView
from apps.optical_flow.record import FlowRecord
from apps.optical_flow.settings import FlowPageSettings
from apps.optical_flow.wanderer import WanderOrders
from apps.web.server import address, listening, page_server, serve_pages
from apps.web.viewer import STYLE, ImageViewer, framed
from configs.loader import ConfigError

_TITLE = "Optical-flow navigation"
_READY = 10.0  # s until the page is served
_LINES = 12  # of what the drive has told
_LOOK = 0.05  # s between two looks for a newer image
_REFRESH = 0.3  # s between two looks for newer words
_FRAMES = "/frames"
_LARGE = ".rv-viewer canvas { width: min(100%, calc(76vh * var(--rv-ratio, 1))); }"


class FlowPage:
    """Serves the page of one drive until it is closed.

    url: for a browser. orders: the latest ones of the drive.
    """

    def __init__(self, port: int, record: FlowRecord, settings: FlowPageSettings) -> None:
        """Serve it.

        Args:
            port: TCP port; 0 for any free one.
            record: Of the drive.
            settings: Of the page.
        Raises:
            ConfigError: The address cannot be used, or this process has served a page before: NiceGUI starts only once.
        """
        self.orders: WanderOrders | None = None
        self._record, self._settings = record, settings
        self._number = 0  # of views that were shown
        self._view: FlowView | None = None
        self._drawn: tuple[int, bytes] = 0, b""
        self._asked_at = -math.inf  # s, when a browser last requested an image
        self._is_stopped = False
        self._server: uvicorn.Server | None = None
        listener = listening(settings.host, port)
        self.url = address(listener, settings.host)
        self._is_ready, self._error = threading.Event(), ""
        self._thread = threading.Thread(target=self._run, args=(listener,), name="flow page", daemon=True)
        self._thread.start()
        if not self._is_ready.wait(_READY) or self._error:
            raise ConfigError(f"the page cannot be served: {self._error or 'it does not start'}")

    @property
    def is_watched(self) -> bool:
        """Whether a browser has requested an image lately."""
        return time.monotonic() - self._asked_at < self._settings.watched_s

    @property
    def is_stopped(self) -> bool:
        """Whether somebody has pressed the button."""
        return self._is_stopped

    def show(self, view: FlowView) -> None:
        """Show an image; it is drawn when a browser requests it."""
        self._view = view
        self._number += 1

    def close(self) -> None:
        """End the page."""
        if self._server is not None:
            self._server.should_exit = True
        self._thread.join(_READY)

    def _run(self, listener: socket.socket) -> None:
        try:
            with listener:
                asyncio.run(self._serve(listener))
        except Exception as err:  # whatever it is, it must neither be lost nor keep the drive waiting
            self._error = in_words(err)
        finally:
            self._is_ready.set()

    async def _serve(self, listener: socket.socket) -> None:
        app = FastAPI(openapi_url=None)
        app.add_api_websocket_route(_FRAMES, self._send_frames)
        ui.page("/")(self._build)
        self._server = page_server(app, _TITLE, self._settings.host)
        await serve_pages(self._server, listener, self._is_ready.set)

    async def _send_frames(self, browser: WebSocket) -> None:
        """Answer the requests of one browser until it ends."""
        await browser.accept()
        sent = 0
        try:
            while True:
                await browser.receive_text()
                begun = self._asked_at = time.monotonic()
                while self._number <= sent and time.monotonic() - begun < self._settings.wait_s:
                    await asyncio.sleep(_LOOK)
                head: dict[str, Any] = {"waited": round(time.monotonic() - begun, 4), "words": ""}
                image, view = b"", self._view
                if self._number > sent and view is not None:
                    sent = self._number
                    image = await asyncio.to_thread(self._encoded, sent, view)
                    age = round(time.time() - view.stamp, 4)
                    head |= {"number": sent, "format": "jpeg", "stamp": view.stamp, "age": age}
                else:
                    head["words"] = "the drive has been stopped" if self._is_stopped else "no new image has come"
                await browser.send_bytes(framed(head, image))
        except (WebSocketDisconnect, RuntimeError):  # RuntimeError: it has been closed while an image was awaited
            return

    def _encoded(self, number: int, view: FlowView) -> bytes:
        """Return the drawing as a JPEG; browsers that look at the same time share it."""
        import cv2  # it takes long to load

        if self._drawn[0] != number:
            self._drawn = number, np.asarray(cv2.imencode(".jpg", view.frame())[1]).tobytes()
        return self._drawn[1]

    def _build(self) -> None:
        """Build the page, for one browser."""
        ui.add_css(STYLE)
        ui.add_css(_LARGE)
        ui.colors(primary="#1a5fb4", negative="#b3261e")
        with ui.row().classes("rv-header"):
            ui.label(f"{_TITLE}: {self._record.robot}").classes("rv-title")
            stop = ui.button("Stop", on_click=self._stop).props("color=negative no-caps")
        with ui.element("main").classes("rv-main"):
            with ui.element("section").classes("rv-column"):
                ImageViewer(
                    _FRAMES, "image, flow, and time to contact", self._settings.old_s, "acromovi run optical_flow"
                )
            with ui.element("section").classes("rv-column"):
                with ui.element("div").classes("rv-panel"):
                    situation = ui.label().classes("rv-heading").props('role="status"')
                    reason, motion = ui.label(), ui.label().classes("rv-where")
                with ui.element("div").classes("rv-panel"):
                    ui.label("Drive").classes("rv-heading")
                    log = ui.element("ol").classes("rv-log").props('aria-live="polite"')
        shown = 0

        def refresh() -> None:
            nonlocal shown
            stop.set_enabled(not self._is_stopped)
            orders, told = self.orders, self._record.told
            if orders is not None:
                situation.text, reason.text = f"Situation: {orders.situation.value}", orders.reason
                twist = orders.twist
                motion.text = f"{twist.linear:.2f} m/s, {math.degrees(twist.angular):.0f} degrees/s"
            if self._is_stopped:
                situation.text, reason.text, motion.text = "Stopped", "the drive has been ended from a page", ""
            if len(told) != shown:
                shown = len(told)
                log.clear()
                with log:
                    for line in reversed(told[-_LINES:]):
                        with ui.element("li"):
                            ui.label(line)

        refresh()
        ui.timer(_REFRESH, refresh)

    def _stop(self) -> None:
        self._is_stopped = True

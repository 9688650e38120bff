"""How old an image is when the browser has drawn it: over loopback, and over a line with delay and loss.

The benchmark plays the camera: JPEG files of 320x240 at 15 Hz on the bus, stamped when they are put there. The agents
of the robot, `acromovi remote-vision` and Chromium are processes of their own. Chromium notes when it has drawn an
image, by the same clock. The line with delay and loss is a TCP relay of the benchmark's own (`_Line`), since it needs
neither rights nor modules of the kernel. `vision` measures from an image to the result of an operation.
"""

import argparse
import asyncio
import random
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from shutil import which

import numpy as np
from playwright.sync_api import Page, sync_playwright

from agents import Team
from benchmarks.figures import Figure, percentile
from benchmarks.vision_drawing import COLOURS, Camera, draw, quads
from bus import ZenohBus, keys
from bus.messages import CompressedImage, header
from configs.defaults import default_bus
from vision.image import Image

GROUP = "remote_vision"
ROBOT = "bench-view"
RATE = 15.0  # Hz
SECONDS = 40.0
SETTLE = 3.0  # s that are not counted
SEED = 130_000
DELAY = 0.05  # s, each way
LOSS = 0.02  # of the segments, each way
SEGMENT = 1448  # bytes
RETRANSMISSION = 0.2  # s, the least that Linux waits for an acknowledgement beyond the way there and back
LOOPBACK_MS, LINE_MS, GROWTH_MS = 120.0, 400.0, 50.0
LISTEN = """() => {
    window.drawn = [];
    document.querySelector(".rv-viewer").addEventListener("drawn", (event) => window.drawn.push(event.detail));
}"""


def measure(options: argparse.Namespace) -> list[Figure]:
    """Measure all figures; none without Chromium."""
    chromium = which("chromium")
    if chromium is None:
        print("     chromium is not installed, so nothing is measured; install it with: apt install chromium")
        return []
    with _robot(), _page_server() as port, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        try:
            near = _delays(browser.new_page(), port)
            with _Line(port) as line:
                far = _delays(browser.new_page(), line.port, line)
        finally:
            browser.close()
    what = "camera to drawn in the browser, 320x240 at 15 Hz"
    worse = f"{what}, {DELAY * 1e3:.0f} ms and {LOSS:.0%} loss each way"
    third = len(far) // 3
    growth = percentile(far[-third:], 50) - percentile(far[:third], 50)
    print(f"     {len(near) / SECONDS:.1f} images a second over loopback, {len(far) / SECONDS:.1f} over the line")
    return [
        Figure(GROUP, f"{what}, loopback, p50", percentile(near, 50), LOOPBACK_MS, "ms", len(near)),
        Figure(GROUP, f"{what}, loopback, p95", percentile(near, 95), LOOPBACK_MS, "ms", len(near)),
        Figure(GROUP, f"{worse}, p50", percentile(far, 50), LINE_MS, "ms", len(far)),
        Figure(GROUP, f"{worse}, p95", percentile(far, 95), LINE_MS, "ms", len(far)),
        Figure(GROUP, f"{worse}, growth of the median from first to last third", growth, GROWTH_MS, "ms", len(far)),
    ]


def _delays(page: Page, port: int, line: "_Line | None" = None) -> list[float]:
    """Milliseconds from the exposure of each image that is drawn until then; a line loses once the page is loaded."""
    page.goto(f"http://127.0.0.1:{port}/")
    page.wait_for_selector(".rv-viewer")
    if line is not None:
        line.loss = LOSS
    page.wait_for_timeout(SETTLE * 1e3)
    page.evaluate(LISTEN)
    page.wait_for_timeout(SECONDS * 1e3)
    drawn = page.evaluate("window.drawn")
    page.close()
    return [(each["at"] - each["stamp"]) * 1e3 for each in drawn]


@contextmanager
def _robot() -> Iterator[None]:
    """A robot with a camera: its agents in a container, and images on the bus while a program subscribes to them."""
    rng = np.random.default_rng(SEED)
    rectangles = list(zip(quads(1.5, 0.0, 0.0, 0.0), COLOURS, strict=True))
    files = [Image.of(draw(Camera(), rectangles, rng)).encode(85) for _ in range(8)]
    row = {"name": "camera", "streams": [], "commands": [], "field_of_view": Camera().view}
    command = (sys.executable, "-m", "acromovi", "container", "--robot", ROBOT, "--json")
    is_over = threading.Event()

    def show(bus: ZenohBus) -> None:
        begun, number = time.monotonic(), 0
        with bus.publisher(keys.CAMERA.key(ROBOT), keys.CAMERA.type_name) as camera:
            while not is_over.wait(max(0.0, begun + number / RATE - time.monotonic())):
                data = np.frombuffer(files[number % len(files)], np.uint8)
                camera.put(CompressedImage(header=header(time.time_ns(), f"{ROBOT}/camera"), format="jpeg", data=data))
                number += 1

    # What the container prints is for people.
    with ZenohBus.open() as bus, subprocess.Popen(command, stdout=subprocess.DEVNULL) as container:
        showing = threading.Thread(target=show, args=(bus,))
        try:
            bus.serve(keys.DESCRIPTION.key(ROBOT), lambda arguments: {"model": "p3dx-sh", "elements": [row]})
            bus.declare_alive(keys.ELEMENT_ALIVE.key(ROBOT, "camera"))
            with Team() as team:
                team.robot(ROBOT, ("camera", "vision"), 30.0)
            showing.start()
            yield
        finally:
            is_over.set()
            if showing.is_alive():
                showing.join()
            container.terminate()


@contextmanager
def _page_server() -> Iterator[int]:
    """The command; gives the port of its page."""
    command = [sys.executable, "-m", "acromovi", "remote-vision", ROBOT, "--port", "0", "--bus", default_bus()]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            yield int(process.stdout.readline().split("://127.0.0.1:")[1].split("/")[0])
        finally:
            process.terminate()


class _Line:
    """A TCP relay with delay and loss. port: where it listens. loss: part of the segments.

    What TCP makes of loss is computed: a lost segment arrives later, and so does all that follows it on the same
    connection. The sender notices at once if three segments follow (fast retransmission, one way there and back), and
    otherwise when its timer ends. Capacity is not limited.
    """

    def __init__(self, target: int) -> None:
        self._target = target
        self._rng = random.Random(SEED)
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever)
        self.port = 0
        self.loss = 0.0

    def __enter__(self) -> "_Line":
        self._thread.start()
        self.port = asyncio.run_coroutine_threadsafe(self._listen(), self._loop).result()
        return self

    def __exit__(self, *error: object) -> None:
        asyncio.run_coroutine_threadsafe(self._leave(), self._loop).result()
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()

    async def _listen(self) -> int:
        self._server = await asyncio.start_server(self._join, "127.0.0.1", 0)
        return int(self._server.sockets[0].getsockname()[1])

    async def _leave(self) -> None:
        self._server.close()
        # A connection that has just been accepted begins its task after the others have been cancelled.
        while left := asyncio.all_tasks() - {asyncio.current_task()}:
            for task in left:
                task.cancel()
            await asyncio.gather(*left, return_exceptions=True)  # each ends as cancelled

    async def _join(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        there, back = await asyncio.open_connection("127.0.0.1", self._target)
        with suppress(asyncio.CancelledError):  # the benchmark is over; streams would report a task that was cancelled
            # either end may go first
            await asyncio.gather(self._carry(reader, back), self._carry(there, writer), return_exceptions=True)

    async def _carry(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Carry one direction: every chunk arrives later, in order."""
        clear = 0.0  # when the latest segment arrives, s of the loop's time
        # A browser that is killed resets its connections, which ends them likewise.
        with suppress(ConnectionResetError):
            while data := await reader.read(1 << 16):
                count = -(-len(data) // SEGMENT)
                for number in range(count):
                    clear = max(clear, self._loop.time() + DELAY + self._retransmission(count - number - 1))
                    segment = data[number * SEGMENT : (number + 1) * SEGMENT]
                    self._loop.call_at(clear, _write, writer, segment)
        self._loop.call_at(max(clear, self._loop.time() + DELAY), writer.close)

    def _retransmission(self, followers: int) -> float:
        """Seconds by which a segment is late by loss; followers: segments sent after it at once."""
        late = 0.0
        while self._rng.random() < self.loss:
            late += 2.0 * DELAY + (0.0 if followers >= 3 else RETRANSMISSION)
        return late


def _write(writer: asyncio.StreamWriter, segment: bytes) -> None:
    if not writer.is_closing():
        writer.write(segment)

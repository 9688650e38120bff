"""Requests that end when the browser in which they were made is gone, frozen or cut off."""

import asyncio
from collections.abc import Coroutine
from typing import Any

from nicegui.element import Element

from apps.console.visits import Visit

_CHECK = 0.2  # s between two looks at the browser


class BrowserPulse(Element, component="pulse.js"):
    """The signs of life of a browser while requests of its page are under way.

    A request to an agent may move a robot. It is cancelled when its page is closed; this cancels it as well when the
    browser falls silent, since nobody could stop the motion from there.
    """

    def __init__(self, visit: Visit, silence: float) -> None:
        """Add it to the page.

        Args:
            visit: The page.
            silence: s without a sign of life after which requests are cancelled.
        """
        super().__init__()
        self._visit, self._silence = visit, silence
        self._heard_at = 0.0
        self._count = 0
        self.on("pulse", self._hear)

    def begin(self, work: Coroutine[Any, Any, None]) -> "asyncio.Task[None]":
        """Do something as long as the browser lives; return the task, which can be cancelled."""
        task = asyncio.ensure_future(self._guard(work))
        self._visit.motions.add(task)
        task.add_done_callback(self._visit.motions.discard)
        return task

    async def _guard(self, work: Coroutine[Any, Any, None]) -> None:
        loop = asyncio.get_running_loop()
        self._heard_at = loop.time()
        self._switch(1)
        inner = asyncio.ensure_future(work)
        try:
            while not inner.done():
                await asyncio.wait([inner], timeout=_CHECK)
                if loop.time() - self._heard_at > self._silence:
                    inner.cancel()
        finally:
            inner.cancel()
            await asyncio.gather(inner, return_exceptions=True)  # it was cancelled
            self._switch(-1)
        if not inner.cancelled():
            inner.result()

    def _switch(self, step: int) -> None:
        self._count += step
        self._props["beats"] = self._count > 0

    def _hear(self) -> None:
        self._heard_at = asyncio.get_running_loop().time()

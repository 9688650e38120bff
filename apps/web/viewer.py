"""The element of a page that shows images, one after the other; `viewer.js` is its part in the browser.

The browser requests each image after it has drawn the one before, and gets the newest one there is. So at most one
image is on its way to each viewer, the delay does not grow however slow the line is, and a viewer that reads nothing
holds up no other.
"""

import json
import struct
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from nicegui.element import Element

STYLE = Path(__file__).with_name("page.css")
"""The style sheet of pages with images."""
SHARED = {"acromovi": str(Path(__file__).with_name("shared"))}
"""JavaScript for the elements of pages, as `Element` takes it: `import { RequestLoop } from "acromovi/requests.js"`."""
LENGTH = struct.Struct(">I")


def framed(head: Mapping[str, Any], body: bytes) -> bytes:
    """Return a reply to a request of `requests.js`: 4 bytes with the length of the head (big-endian), head and body.

    Args:
        head: A JSON object. For an image: `number`, `words` over the image, `waited`, s for the image, and optionally
            `stamp`, `age`, s, and what `viewer.js` draws over the image.
        body: Of an image the file; empty without a new image.
    """
    data = json.dumps(head).encode()
    return b"".join((LENGTH.pack(len(data)), data, body))


class ImageViewer(Element, component="viewer.js", esm=SHARED):
    """An image that is requested, drawn, and requested again.

    Events: `point` {at, size}, `drag` {from, to, size, is_first}, `region` {region, size}, all in px of the image;
    `key` {key}.
    """

    def __init__(self, path: str, label: str, old: float, program: str, mode: str = "show") -> None:
        """Add it to the page.

        Args:
            path: Of the websocket of its images.
            label: Above the image.
            old: s of age from which on it is marked as old.
            program: That sends the images, for people.
            mode: What the pointer does: `show` nothing, `steer` the head, `train` a colour.
        """
        super().__init__()
        self._props["path"] = path
        self._props["label"] = label
        self._props["old"] = old
        self._props["program"] = program
        self.mode = mode

    @property
    def mode(self) -> str:
        """What the pointer does."""
        return str(self._props["mode"])

    @mode.setter
    def mode(self, mode: str) -> None:
        self._props["mode"] = mode

    def rename(self, label: str) -> None:
        """Show another label."""
        self._props["label"] = label

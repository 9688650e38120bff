"""The element of the page that shows one image; `viewer.js` is its part in the browser."""

from nicegui.element import Element


class ImageViewer(Element, component="viewer.js"):
    """An image that is requested, drawn, and requested again.

    Events: `point` {at, size}, `drag` {from, to, size, is_first}, `region` {region, size}, all in px of the image;
    `key` {key}.
    """

    def __init__(self, path: str, label: str, old: float, mode: str = "show") -> None:
        """Add it to the page.

        Args:
            path: Of the websocket of its images.
            label: Above the image.
            old: s of age from which on it is marked as old.
            mode: What the pointer does: `show` nothing, `steer` the head, `train` a colour.
        """
        super().__init__()
        self._props["path"] = path
        self._props["label"] = label
        self._props["old"] = old
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

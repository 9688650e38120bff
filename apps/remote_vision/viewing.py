"""The state of one viewing: a page in a browser, what it shows, and since when it has been silent. Pure."""

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from apps.remote_vision.operations import OperationChoice
from apps.remote_vision.streams import StreamItem

ORIGINAL, RESULT = "original", "result"
"""The two images of a page: that of the camera, and the result of an operation."""
COLOURS, MOTION = "colours", "motion"
"""The agents whose blobs are drawn over the image."""
VISION = "vision"
"""The agent of the operations."""
MOST_OUTCOMES = 30


@dataclass(slots=True)
class Viewing:
    """One page.

    ticket: secret part of the addresses of its images. name: for people. robot: whose camera is shown; empty for none.
    keys: of the streams shown, by place; a place without a key shows nothing. choice: of an operation. overlays: the
    agents whose blobs are drawn. seen_at: s of the loop's time of the latest request for an image of the camera.
    sockets: of the browser, by which it requests these. shown: the latest item of each place that was sent. outcomes:
    of the latest commands, the newest first: time of the day and words. outcome_count: of all of them.
    """

    ticket: str
    name: str
    robot: str = ""
    keys: dict[str, str] = field(default_factory=dict)
    choice: OperationChoice = field(default_factory=OperationChoice)
    overlays: set[str] = field(default_factory=set)
    seen_at: float = 0.0
    sockets: int = 0
    shown: dict[str, StreamItem] = field(default_factory=dict)
    outcomes: deque[tuple[str, str]] = field(default_factory=lambda: deque(maxlen=MOST_OUTCOMES))
    outcome_count: int = 0

    def tell(self, clock: str, words: str) -> None:
        """Note what has happened, at a time of the day."""
        self.outcomes.appendleft((clock, words))
        self.outcome_count += 1

    @property
    def is_open(self) -> bool:
        """Whether the browser is connected for images of the camera."""
        return self.sockets > 0

    def silence(self, now: float) -> float:
        """Return the s since the browser last asked for an image of the camera."""
        return max(now - self.seen_at, 0.0)


def image_words(robot: str, silence: float, is_robot_there: bool, has_camera: bool) -> str:
    """Return why there is no new image, for a person.

    Args:
        robot: Its name.
        silence: s without an image.
        is_robot_there: Whether any agent of the robot is present.
        has_camera: Whether the agent of its camera is.
    """
    if not is_robot_there:
        return f"{robot} is not on the bus; the image returns by itself when it is back"
    if not has_camera:
        return f"the camera of {robot} is lost; the image returns by itself when it is connected again"
    return f"no image has come from {robot} for {silence:.1f} s"


def boxes(source: str, values: Mapping[str, Any] | None) -> list[dict[str, Any]]:
    """Return the rectangles to draw over an image: px, with a label, and the source for the colour.

    Args:
        source: `colours` or `motion`.
        values: The latest result of that agent; None if there is none.
    """
    if values is None:
        return []
    if source == MOTION:
        return [_box(source, "motion", blob) for blob in values.get("blobs", ())]
    return [
        _box(source, f"channel {channel}", blob)
        for channel, blobs in values.get("channels", {}).items()
        for blob in blobs
    ]


def _box(source: str, label: str, blob: Mapping[str, Any]) -> dict[str, Any]:
    return {"source": source, "label": label, **{side: blob[side] for side in ("left", "top", "right", "bottom")}}

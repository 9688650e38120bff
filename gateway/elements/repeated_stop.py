"""Stopping an element again until its reports show that it rests: the robot confirms no frame, and one may be lost."""

REPEAT = 0.15
"""Seconds after which an element that still moves is told to stop again."""
BELIEVED = 1.0
"""Seconds after which a report of rest is believed; one before may be older than the motion."""


class RepeatedStop:
    """Says when an element that was told to stop is to be told again."""

    def __init__(self) -> None:
        """Nothing was stopped yet."""
        self._is_wanted = False
        self._since: float | None = None
        self._told_at = 0.0

    def begin(self) -> None:
        """Note that the element was told to stop."""
        self._is_wanted, self._since = True, None

    def end(self) -> None:
        """Note that the element has a newer order."""
        self._is_wanted = False

    def is_due(self, is_moving: bool, now: float) -> bool:
        """Take a report of the element; return whether to tell it again. now: steady time, s."""
        if not self._is_wanted:
            return False
        if self._since is None:
            self._since = self._told_at = now
        if not is_moving:
            self._is_wanted = now - self._since < BELIEVED
            return False
        if now - self._told_at < REPEAT:
            return False
        self._told_at = now
        return True

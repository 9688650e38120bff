"""Dials a radio modem's partner, as clients of these robots have always done.

The modem repeats what it was told, and says when it has found its partner. One that says nothing may be connected all
the same: the dial string then goes through to the robot, which takes it for noise. So the robot is tried in any case.
"""

FOUND = b"onnected to address"
"""What the modem says once it has found its partner; the capital in front differs. Source: client libraries."""
FIRST_PATIENCE = 1.0
LONGEST_PATIENCE = 4.0
"""Seconds to wait for that, at first and after many times in vain."""


class Dialler:
    """One modem.

    frame: what to write. has_answered: since `begin`. patience: how long to wait for that, s.
    """

    def __init__(self, frame: bytes) -> None:
        """frame: the dial string."""
        self.frame = frame
        self.has_answered = False
        self.patience = FIRST_PATIENCE
        self._heard = b""

    def begin(self) -> None:
        """The dial string is on its way."""
        self.has_answered = False
        self._heard = b""

    def hear(self, data: bytes) -> None:
        """Take bytes from the line."""
        self._heard = (self._heard + data)[-len(FOUND) - len(data) :]
        if FOUND in self._heard:
            self.has_answered = True
            self.patience = FIRST_PATIENCE

    def give_up(self) -> None:
        """It has not answered; wait longer the next time."""
        self.patience = min(2.0 * self.patience, LONGEST_PATIENCE)

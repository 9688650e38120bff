"""What a panel of the page Robot is."""

from typing import Protocol

from apps.console.program import Console
from apps.console.visits import Visit


class RobotPanel(Protocol):
    """One panel. It is built when its element appears, and removed when that disappears."""

    def __init__(self, console: Console, visit: Visit) -> None:
        """Build it in the present place of the page, for the robot of the page."""

    def refresh(self) -> None:
        """Show the newest readings; called a few times a second."""

"""The page Robot."""

from apps.console.page import panel
from apps.console.program import Console
from apps.console.visits import Visit


def build(console: Console, visit: Visit) -> None:
    """Build the page."""
    with panel("Robot"):
        pass

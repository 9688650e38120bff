"""The map in a page; `map.js` draws it."""

from nicegui.element import Element

from apps.console.visits import Visit
from apps.web.viewer import SHARED

LAYERS = ("walls", "seen", "sonar", "laser", "trails", "missions", "located", "goals", "overlays", "names")


class MapCanvas(Element, component="map.js", esm=SHARED):
    """A map of the team.

    Events: `choose` {robot}, empty for none; `goal` {robot, x, y, heading}, on the map, m and rad, heading null for
    any; in the modes `place` and `relocate`, `place` and `relocate` {robot, x, y, heading} likewise. In mode `send` a
    click on a named goal of the chosen robot's map is `named` {robot, name}.
    """

    def __init__(self, visit: Visit, chosen: str = "", mode: str = "look") -> None:
        """Add it to the page.

        Args:
            visit: The page.
            chosen: Robot that is chosen at first.
            mode: What the pointer does: `look` chooses robots and moves the map; `send`, `place` and `relocate` give a
                pose as well.
        """
        super().__init__()
        self._props["path"] = f"/map/{visit.ticket}"
        self._props["chosen"] = chosen
        self._props["mode"] = mode
        self._props["layers"] = list(LAYERS)
        self._props["follow"] = False

    @property
    def mode(self) -> str:
        """What the pointer does."""
        return str(self._props["mode"])

    @mode.setter
    def mode(self, mode: str) -> None:
        self._props["mode"] = mode

    @property
    def chosen(self) -> str:
        """The robot that is chosen; empty for none."""
        return str(self._props["chosen"])

    @chosen.setter
    def chosen(self, robot: str) -> None:
        self._props["chosen"] = robot

    def show(self, layers: list[str]) -> None:
        """Show some of `LAYERS`."""
        self._props["layers"] = layers

    def follow(self, on: bool) -> None:
        """Keep the chosen robot in the middle, or not."""
        self._props["follow"] = on

    def fit(self) -> None:
        """Show all of the map."""
        self.run_method("fit")

"""The sonar: its readings come with the SIPs, and it can be switched."""

from gateway.elements.element import Element
from p2os import Command, RobotModel


class SonarElement(Element):
    """Remembers whether it is to be on, to switch it again after a reset."""

    def begin_link(self, model: RobotModel, now: float) -> None:
        """Switch it as the settings want it, or as it was switched since."""
        if not self.is_present:
            self._wanted = self._settings.sonar
            self.is_present = True
        if self._wanted is not None:
            self.switch(self._wanted)

    def switch(self, on: bool) -> None:
        """All arrays on or off."""
        self._wanted = on
        self._ask(Command.SONAR, int(on))

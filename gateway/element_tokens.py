"""A token on the bus for each element of a robot, by which agents are made and ended.

They stand for what the robot is known to have, not for what works just now: a cable that is cut for a second ends no
agent. An element on a cable of its own that does not answer is one that the robot does not have.
"""

from collections.abc import Iterable

from bus import Bus, Subscription, keys


class ElementTokens(Subscription):
    """One robot's tokens. All calls come from one thread."""

    def __init__(self, robot: str, bus: Bus) -> None:
        self._robot = robot
        self._bus = bus
        self._shown: dict[str, Subscription] = {}

    def follow(self, present: Iterable[str]) -> None:
        """Show the tokens of these elements, and no others."""
        wanted = set(present)
        if wanted == self._shown.keys():
            return
        for element in self._shown.keys() - wanted:
            self._shown.pop(element).close()
        for element in sorted(wanted - self._shown.keys()):
            self._shown[element] = self._bus.declare_alive(keys.element_alive_key(self._robot, element))

    def close(self) -> None:
        """Withdraw them all."""
        self.follow(())

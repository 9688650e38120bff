"""A container that records what its agents say."""

from collections.abc import Callable

from agents.platform import Container, Report
from agents.platform.acl import AclMessage
from bus import Bus


class TracedContainer(Container):
    """Adds each message that an agent in it sends to a list, which several containers may share."""

    def __init__(
        self,
        bus: Bus,
        name: str,
        on_report: Callable[[Report], None],
        clock: Callable[[], float],
        said: list[AclMessage],
    ) -> None:
        super().__init__(bus, name, on_report, clock)
        self.said = said

    def trace(self, message: AclMessage) -> None:
        self.said.append(message)

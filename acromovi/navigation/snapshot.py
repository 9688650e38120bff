"""The data of a picture: path planning's knowledge, the motion commands, and the robot's outline."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Self

if TYPE_CHECKING:
    from bus.bus import Bus

ENDED = ("done", "failed", "cancelled")


@dataclass(frozen=True, slots=True)
class Snapshot:
    """Replies of the components; empty where a component did not answer.

    planning: to path planning's query `picture`. commands: to the fuser's `commands`. body: to the base's `robot`.
    """

    robot: str
    planning: Mapping[str, Any] = field(default_factory=dict)
    commands: Mapping[str, Any] = field(default_factory=dict)
    body: Mapping[str, Any] = field(default_factory=dict)

    @property
    def title(self) -> str:
        """State of the mission in one line."""
        told = self.planning
        if not told.get("mission"):
            return f"{self.robot}: no mission yet"
        why = f" ({told['why']})" if told.get("why") else ""
        return f"{self.robot}, {told['mission']}: {told.get('state')}{why}, {told.get('travelled') or 0.0:.1f} m so far"

    @classmethod
    def of(cls, bus: "Bus", robot: str) -> Self:
        """Query the components.

        Raises:
            NotOnBus: The navigation of this robot does not run.
            RequestNotDone: Path planning does not answer.
        """
        from acromovi.navigation.components import RunningNavigation

        running = RunningNavigation(bus, robot)
        planning = running.ask("picture")
        commands = running.query("motion_fuser", "commands")
        return cls(robot, planning, commands, running.query("robot_base_server", "robot"))

"""The agent of the wheels' shaft encoders."""

from typing import Any

from agents.components.generic import Generic
from bus.keys import frame


class EncodersAgent(Generic):
    """Angles of the driven wheels, rad from the first packet on. They share `joint_states` with arm and gripper."""

    eager = True

    async def _hear(self, message: Any) -> None:
        if frame(self.robot, "left_wheel") in message.name:
            await super()._hear(message)

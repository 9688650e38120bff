"""Our own messages, for what no standard type says: the Python side of `bus/msg/*.msg`.

Array fields take any sequence and hold a numpy array, which indexes, iterates and has a length like one.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from rosbags.typesys.stores.ros2_jazzy import sensor_msgs__msg__Range as Range
from rosbags.typesys.stores.ros2_jazzy import std_msgs__msg__Header as Header

__all__ = ["ACROMOVI_MESSAGES", "Bumpers", "InputsOutputs", "RangeArray", "RobotState"]

Booleans = Sequence[bool] | NDArray[np.bool_]
Floats = Sequence[float] | NDArray[np.float32]


@dataclass
class RangeArray:
    """Ranges of one kind of sensor, measured at about the same time.

    ranges: m, one per reading, each in the frame of its own sensor (`<robot>/sonar_3`).
    """

    header: Header
    ranges: list[Range] = field(default_factory=list)
    __msgtype__: ClassVar[str] = "acromovi_msgs/msg/RangeArray"


@dataclass(eq=False)
class Bumpers:
    """Contact segments and wheel stalls.

    front, rear: element i is segment i + 1; segments count from right to left in front and behind, seen from above with
        the robot facing up the page. Empty where the robot has no bumper.
    """

    header: Header
    front: Booleans = ()
    rear: Booleans = ()
    stall_left: bool = False
    stall_right: bool = False
    __msgtype__: ClassVar[str] = "acromovi_msgs/msg/Bumpers"

    def __post_init__(self) -> None:
        self.front = np.asarray(self.front, np.bool_)
        self.rear = np.asarray(self.rear, np.bool_)


@dataclass
class RobotState:
    """What the robot's microcontroller and the way to it are doing.

    connection: `disconnected`, `connecting` or `connected`, as the gateway sees the cable.
    motors: motor power is on.
    estop: an emergency stop holds the robot: its button, its firmware, or the latched `estop` command.
    sonar: at least one sonar array fires.
    flags: the FLAGS word of the last SIP, unchanged.
    faults: what is wrong, a sentence each; empty when all is well.
    """

    header: Header
    connection: str
    motors: bool = False
    estop: bool = False
    sonar: bool = False
    flags: int = 0
    faults: list[str] = field(default_factory=list)
    __msgtype__: ClassVar[str] = "acromovi_msgs/msg/RobotState"


@dataclass(eq=False)
class InputsOutputs:
    """The microcontroller's user ports.

    digital_in, digital_out: element i is pin i, lowest bit of the first byte first.
    analog_in: V.
    """

    header: Header
    digital_in: Booleans = ()
    digital_out: Booleans = ()
    analog_in: Floats = ()
    __msgtype__: ClassVar[str] = "acromovi_msgs/msg/InputsOutputs"

    def __post_init__(self) -> None:
        self.digital_in = np.asarray(self.digital_in, np.bool_)
        self.digital_out = np.asarray(self.digital_out, np.bool_)
        self.analog_in = np.asarray(self.analog_in, np.float32)


ACROMOVI_MESSAGES = (RangeArray, Bumpers, RobotState, InputsOutputs)

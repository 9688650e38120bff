"""Our own messages, for what no standard type says: the Python side of `bus/msg/*.msg`, to which a test holds them.

Array fields take any sequence and hold a numpy array, which indexes, iterates and has a length like one.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Annotated, ClassVar

import numpy as np
from numpy.typing import NDArray

from bus.field_types import Bool, Float32, String, Strings, UInt16
from bus.ros_msgs import Header, Range, Vector3

Booleans = Annotated[Sequence[bool] | NDArray[np.bool_], "bool[]"]
Floats = Annotated[Sequence[float] | NDArray[np.float32], "float32[]"]


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
    stall_left: Bool = False
    stall_right: Bool = False
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
    connection: String
    motors: Bool = False
    estop: Bool = False
    sonar: Bool = False
    flags: UInt16 = 0
    faults: Strings = field(default_factory=list)
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


@dataclass
class Gripper:
    """A gripper: two paddles on a lift. Where both of a pair are false, it is in between.

    outer_beam, inner_beam: something stands in the beam between the paddles.
    left_contact, right_contact: something presses on the paddle.
    """

    header: Header
    fitted: Bool = True
    paddles_open: Bool = False
    paddles_closed: Bool = False
    paddles_moving: Bool = False
    lift_up: Bool = False
    lift_down: Bool = False
    lift_moving: Bool = False
    outer_beam: Bool = False
    inner_beam: Bool = False
    left_contact: Bool = False
    right_contact: Bool = False
    __msgtype__: ClassVar[str] = "acromovi_msgs/msg/Gripper"


@dataclass(eq=False)
class Arm:
    """An arm; its joints are in `<robot>/joint_states`, in the same order.

    homed: every joint has found its zero.
    """

    header: Header
    powered: Bool = False
    homed: Bool = False
    moving: Booleans = ()
    __msgtype__: ClassVar[str] = "acromovi_msgs/msg/Arm"

    def __post_init__(self) -> None:
        self.moving = np.asarray(self.moving, np.bool_)


@dataclass
class PanTiltZoom:
    """A camera on a head: pan rad to the left, tilt rad up, zoom the magnification, 1 at the widest."""

    header: Header
    pan: Float32 = 0.0
    tilt: Float32 = 0.0
    zoom: Float32 = 1.0
    moving: Bool = False
    __msgtype__: ClassVar[str] = "acromovi_msgs/msg/PanTiltZoom"


@dataclass
class Compass:
    """A compass module.

    heading: rad, counter-clockwise from magnetic north seen from above (REP 103). pitch, roll: rad.
    magnetic_field: T, in the module's frame. temperature: °C. errors: the module's error word, unchanged.
    """

    header: Header
    heading: Float32
    pitch: Float32
    roll: Float32
    magnetic_field: Vector3
    temperature: Float32 = 0.0
    errors: UInt16 = 0
    __msgtype__: ClassVar[str] = "acromovi_msgs/msg/Compass"


ACROMOVI_MESSAGES = (RangeArray, Bumpers, RobotState, InputsOutputs, Gripper, Arm, PanTiltZoom, Compass)

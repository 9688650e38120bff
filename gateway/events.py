"""Events that drivers report, in their order. A packet whose fields say all is an event itself."""

from collections.abc import Mapping
from enum import StrEnum
from typing import TYPE_CHECKING, Any, NamedTuple

from gateway.errors import GatewayError
from geometry import Pose2D
from p2os import (
    CompassReport,
    Configuration,
    Encoders,
    Identity,
    IoReport,
    JoystickReport,
    RobotModel,
    StandardSip,
)

if TYPE_CHECKING:  # numpy takes longer to load than the robot to answer
    from p2os.accessories.lms import LmsConfiguration, Scan, Variant


class HandshakeCompleted(NamedTuple):
    """A robot has identified itself; it is opened and configured next. baud: bit/s at which it answered."""

    identity: Identity
    model: RobotModel
    baud: int


class SipReceived(NamedTuple):
    """A plausible SIP.

    pose: in `odom`, continuous over roll-overs and reconnects. covariance: of x, y, heading, row by row, 3 by 3.
    linear, angular: velocity in `base_link`, m/s and rad/s.
    is_first: the first since a handshake: from here on the robot is connected.
    """

    sip: StandardSip
    pose: Pose2D
    covariance: tuple[float, ...]
    linear: float
    angular: float
    is_first: bool


class GripperSeen(NamedTuple):
    """State of the gripper. Where both of a pair are false, it is in between or unknown."""

    paddles_open: bool
    paddles_closed: bool
    paddles_moving: bool
    lift_up: bool
    lift_down: bool
    lift_moving: bool
    outer_beam: bool
    inner_beam: bool
    left_contact: bool
    right_contact: bool


class ArmSeen(NamedTuple):
    """State of the arm. positions: of each joint, rad; of a gripper at the end, m. homed: the positions are valid."""

    powered: bool
    homed: bool
    moving: tuple[bool, ...]
    positions: tuple[float, ...]


class GripperJoints(NamedTuple):
    """Positions of the gripper's joints, m: opening between the paddles, height of the lift; None if unknown."""

    opening: float | None
    lift: float | None


class HeadSeen(NamedTuple):
    """Position of the camera head: rad to the left, rad up, magnification (1 at the widest)."""

    pan: float
    tilt: float
    zoom: float
    moving: bool


class PictureTaken(NamedTuple):
    """A camera has made a picture: a JPEG file, and its size in pixels."""

    jpeg: bytes
    width: int
    height: int


class LinkLost(NamedTuple):
    """The robot was connected and is lost; the driver searches for it again."""

    reason: str


class SweepFailed(NamedTuple):
    """No robot was found in one sweep of all rates.

    rates: bit/s tried. bytes_heard: how many bytes came all the same. frames_heard: sound frames among them.
    answers_at: bit/s of another rate at which a robot answered, None if it did not or was not looked for there.
    """

    rates: tuple[int, ...]
    bytes_heard: int
    frames_heard: int = 0
    answers_at: int | None = None


class RobotRejected(NamedTuple):
    """A robot answers that this gateway cannot serve."""

    error: GatewayError


class TurnRateSeen(NamedTuple):
    """Reading of the gyro. rate: mean over the duration (s), rad/s counter-clockwise, with its variance."""

    rate: float
    variance: float
    duration: float


class CompassSeen(NamedTuple):
    """Reading of the compass. heading: rad counter-clockwise from magnetic north; the rest as in the report."""

    report: CompassReport
    heading: float


class InfraredSeen(NamedTuple):
    """Readings of the infrared sensors: number of the sensor, and whether something is near."""

    near: tuple[tuple[int, bool], ...]


class ChargeSeen(NamedTuple):
    """Charge that the batteries report, 0 to 1."""

    fraction: float


class ElementFound(NamedTuple):
    """An element on a cable of its own was found.

    element: its name, as on the bus. baud: bit/s at which it answers, 0 for a line without a rate.
    """

    element: str
    baud: int


class ElementLost(NamedTuple):
    """An element on a cable of its own is lost; its driver searches for it again."""

    element: str
    reason: str


class ElementSilent(NamedTuple):
    """No element was found on its cable in one sweep of all rates."""

    element: str


class LaserScanned(NamedTuple):
    """A scan of the laser.

    variant, configuration: as the laser has them. age: since its first beam, when the last byte came, s.
    period: between scans, s.
    """

    scan: "Scan"
    variant: "Variant"
    configuration: "LmsConfiguration"
    age: float
    period: float


class SweepReceived(NamedTuple):
    """A sweep of the laser that a simulator sends on the robot's own line.

    ranges: m, from the first bearing on, counter-clockwise. reflectances: as the simulator has them; empty if it sends
    none. first_bearing: rad counter-clockwise from straight ahead. step: between two readings, rad. age: since the
    first packet of the sweep, s. period: between sweeps, s.
    """

    ranges: tuple[float, ...]
    reflectances: tuple[int, ...]
    first_bearing: float
    step: float
    age: float
    period: float


class MotionEnd(StrEnum):
    """How a long motion ended.

    Only stall bits in the SIPs make it STALLED. A robot that rests elsewhere than at the goal has gone too far
    (OVERSHOOT), not far enough (UNDERSHOOT), or never moved (NOT_STARTED). STOPPED is by a command; STOPPED_BY_ROBOT is
    by its STOP button, its emergency stop, or because it switched its motors off.
    """

    REACHED = "reached"
    REPLACED = "replaced"
    STOPPED = "stopped"
    STOPPED_BY_ROBOT = "stopped by the robot"
    STALLED = "stalled"
    COMMANDER_LOST = "commander lost"
    OVERSHOOT = "overshoot"
    UNDERSHOOT = "undershoot"
    NOT_STARTED = "did not start"
    LOST = "lost"
    TIMEOUT = "timeout"


class MotionEnded(NamedTuple):
    """A move or a turn is over.

    motion_id: as its answer gave it. done, goal: what was covered and what was asked for, signed; m or rad, as unit
    says.
    """

    motion_id: str
    kind: str
    end: MotionEnd
    done: float
    goal: float
    unit: str

    @property
    def sentence(self) -> str:
        """How it ended, with the part of the goal that was covered."""
        covered = f"{self.done:.2f} of {self.goal:.2f} {self.unit}"
        match self.end:
            case MotionEnd.OVERSHOOT | MotionEnd.UNDERSHOOT:
                return f"{self.end.value} by {abs(self.goal - self.done):.2f} {self.unit}: {covered}"
            case MotionEnd.REACHED | MotionEnd.NOT_STARTED:
                return f"{self.end.value}: {covered}"
        return f"{self.end.value} after {covered}"

    def as_json(self) -> Mapping[str, Any]:
        """Return the JSON object for `<robot>/command/result/<id>`."""
        return {
            "id": self.motion_id,
            "command": self.kind,
            "result": self.end.value,
            "done": round(self.done, 4),
            "goal": round(self.goal, 4),
            "unit": self.unit,
            "text": self.sentence,
        }


Event = (
    HandshakeCompleted
    | SipReceived
    | Configuration
    | Encoders
    | IoReport
    | GripperSeen
    | GripperJoints
    | TurnRateSeen
    | CompassSeen
    | JoystickReport
    | InfraredSeen
    | ChargeSeen
    | HeadSeen
    | PictureTaken
    | ArmSeen
    | LinkLost
    | SweepFailed
    | RobotRejected
    | ElementFound
    | ElementLost
    | ElementSilent
    | LaserScanned
    | SweepReceived
    | MotionEnded
)

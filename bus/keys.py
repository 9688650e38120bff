"""All keys on the bus: message type, rate and meaning of each.

A key is `<robot>/<suffix>`. Publishers, `acromovi topics` and the documentation read this one table.
"""

from dataclasses import dataclass
from enum import StrEnum

from bus.bus import JSON
from bus.errors import KeyNotValid
from bus.validation import quoted

FORBIDDEN_IN_NAMES = frozenset("/*$?#")
LONGEST_ROBOT_NAME = 100
"""Characters of a robot's name, or of another chunk of a key that names somebody; keys are made of several."""


class Kind(StrEnum):
    """The direction of a key."""

    STREAM = "stream"  # the robot publishes
    COMMAND = "command"  # the robot listens
    QUERY = "query"  # the robot answers
    TOKEN = "token"  # liveliness; carries nothing


@dataclass(frozen=True, slots=True)
class Topic:
    """A row of the table.

    suffix: what follows the robot's name; `*` stands for one chunk that varies.
    type_name: the message type, or `application/json`.
    rate: how often, for the documentation.
    """

    suffix: str
    kind: Kind
    type_name: str
    rate: str
    meaning: str

    @classmethod
    def stream(cls, suffix: str, type_name: str, rate: str, meaning: str) -> "Topic":
        """Return a row for what the robot publishes."""
        return cls(suffix, Kind.STREAM, type_name, rate, meaning)

    @classmethod
    def query(cls, suffix: str, meaning: str) -> "Topic":
        """Return a row for what the robot answers, in JSON."""
        return cls(suffix, Kind.QUERY, JSON, "", meaning)

    def key(self, robot: str, varied: str = "*") -> str:
        """Return the topic's key for one robot.

        Args:
            robot: Its name.
            varied: Takes the place of `*`: the id of a motion, the name of an element.
        Raises:
            KeyNotValid: The name is not valid for a robot.
        """
        return f"{robot_name(robot)}/{self.suffix.replace('*', varied)}"


ODOM = Topic.stream(
    "odom",
    "nav_msgs/msg/Odometry",
    "every SIP",
    "Pose in <robot>/odom, twist in <robot>/base_link; "
    "the origin of odom is where the robot stood when its gateway first connected",
)
SONAR = Topic.stream(
    "sonar", "acromovi_msgs/msg/RangeArray", "every SIP", "Fresh sonar ranges, each in its disc's frame"
)
SONAR_POINTS = Topic.stream(
    "sonar/points", "sensor_msgs/msg/PointCloud2", "every SIP", "Valid sonar echoes in <robot>/base_link"
)
IR = Topic.stream("ir", "acromovi_msgs/msg/RangeArray", "with IOpac", "Infrared ranges")
SCAN = Topic.stream("scan", "sensor_msgs/msg/LaserScan", "every scan", "Laser ranges")
BUMPERS = Topic.stream("bumpers", "acromovi_msgs/msg/Bumpers", "every SIP", "Contact segments and wheel stalls")
BATTERY = Topic.stream("battery", "sensor_msgs/msg/BatteryState", "1 Hz and on change", "Voltage and charging")
STATE = Topic.stream(
    "state", "acromovi_msgs/msg/RobotState", "on change and 1 Hz", "Connection, motors, e-stop, sonar, faults"
)
IO = Topic.stream("io", "acromovi_msgs/msg/InputsOutputs", "with IOpac", "User inputs and outputs")
IMU = Topic.stream("imu", "sensor_msgs/msg/Imu", "as packets come", "Turn rate of the gyro")
JOYSTICK = Topic.stream("joystick", "sensor_msgs/msg/Joy", "as packets come", "The joystick on the robot")
GRIPPER = Topic.stream(
    "gripper", "acromovi_msgs/msg/Gripper", "as packets come", "Paddles, lift, break-beams, contacts"
)
ARM = Topic.stream(
    "arm", "acromovi_msgs/msg/Arm", "as packets come", "Power and motion; the joints are in joint_states"
)
PTZ = Topic.stream("ptz", "acromovi_msgs/msg/PanTiltZoom", "10 Hz while moving", "Pan, tilt and zoom")
COMPASS = Topic.stream("compass", "acromovi_msgs/msg/Compass", "as packets come", "Heading and magnetic field")
LEASE = Topic.query("lease", "Take, renew or release the right to move the robot or an element")
LEASE_STATE = Topic.stream("lease/state", JSON, "on change", "Who holds the leases; a query gives it too")
JOINT_STATES = Topic.stream(
    "joint_states", "sensor_msgs/msg/JointState", "with encoders, arm, gripper", "Angles and speeds"
)
CAMERA = Topic.stream(
    "camera/image/compressed", "sensor_msgs/msg/CompressedImage", "camera rate", "Pictures, JPEG or PNG"
)
CAMERA_INFO = Topic.stream(
    "camera/camera_info", "sensor_msgs/msg/CameraInfo", "camera rate", "Model of a calibrated camera"
)
POSE = Topic.stream(
    "pose",
    "geometry_msgs/msg/PoseWithCovarianceStamped",
    "10 Hz while localized",
    "Pose in map, by the agent localization; only while it believes the pose",
)
TF = Topic.stream(
    "tf", "tf2_msgs/msg/TFMessage", "with odometry", "Where <robot>/base_link is in <robot>/odom, and that in map"
)
TF_STATIC = Topic.stream("tf_static", "tf2_msgs/msg/TFMessage", "1 Hz", "Where the sensors are on the robot")
MAP = Topic.stream("map", "nav_msgs/msg/OccupancyGrid", "on change", "Map of the building, in the frame map")
OVERLAY = Topic.stream(
    "overlay/*",
    JSON,
    "2 Hz while it runs",
    "What an application shows of the robot on maps; * is its name: "
    '{"frame": "base_link", "words": "0.8 m behind", "points": [[x, y]], "lines": [[x1, y1, x2, y2]]}',
)
DIAGNOSTICS = Topic.stream(
    "diagnostics", "diagnostic_msgs/msg/DiagnosticArray", "1 Hz", "Counters and health of robot, cable and gateway"
)
DESCRIPTION = Topic.query("description", "Model, elements, geometry, versions, emulated or not")
CMD_VEL = Topic(
    "cmd_vel", Kind.COMMAND, "geometry_msgs/msg/Twist", "≥ 2 Hz while moving", "Drive; stops after 0.5 s of silence"
)
CMD_VEL_STAMPED = Topic(
    "cmd_vel_stamped", Kind.COMMAND, "geometry_msgs/msg/TwistStamped", "≥ 2 Hz while moving", "Drive, with a stamp"
)
DRIVE = Topic.query(
    "command/drive", 'One velocity, as on cmd_vel but answered, m/s and rad/s: {"linear": 0.2, "angular": 0.0}'
)
ENABLE = Topic.query("command/enable", 'Motor power: {"on": true}')
STOP = Topic.query("command/stop", "Stop, and hold until cmd_vel has been silent for 0.5 s: {}")
ESTOP = Topic.query("command/estop", 'Emergency stop, latched until {"on": false} and enable: {"on": true}')
MOVE = Topic.query("command/move", 'Drive a distance in m, backward if negative: {"distance": 1.0}')
TURN = Topic.query("command/turn", 'Turn by an angle in rad, counter-clockwise: {"angle": 1.57}')
HEADING = Topic.query("command/heading", 'Turn to a heading in <robot>/odom, rad: {"heading": 0.0}')
SONAR_POWER = Topic.query("command/sonar", 'Sonar on or off: {"on": true}')
OUTPUT = Topic.query("command/output", 'Set the digital outputs that mask names: {"mask": 1, "value": 1}')
GRIP = Topic.query("command/gripper", 'Gripper: {"do": "open"}; close, up, down, stop, store, deploy, halt')
REACH = Topic.query(
    "command/arm", 'Arm: {"do": "move", "joints": {"1": 0.5}, "speed": 0.3} in rad; home, park, stop, power with "on"'
)
LOOK = Topic.query("command/ptz", 'Camera head, rad, rad and ratio: {"pan": 0.5, "tilt": 0.1, "zoom": 2.0}')
SOUND = Topic.query(
    "command/sound",
    'Buzzer or sound: {"notes": [[60, 0.2]]} as MIDI notes and s, {"number": 3}, or {"on": false} to mute',
)
CHARGE = Topic.query("command/charge", 'Put out or draw in the charging contacts: {"on": true}')
LCD = Topic.query("command/lcd", 'Write on the display: {"text": "hello"}')
SERVO = Topic.query("command/servo", 'Pulse of an RC servo, s: {"port": 1, "pulse": 0.0015}')
JOYDRIVE = Topic.query("command/joystick", 'Let the joystick on the robot drive it: {"on": true}')
POWER = Topic.query("command/power", 'Switch a power output: {"output": "laser", "on": true}; the answer lists them')
RESULT = Topic.stream("command/result/*", JSON, "once", "How a long motion ended; * is the id in its answer")
ALIVE = Topic("alive", Kind.TOKEN, "", "", "There while the robot's gateway lives; how programs list robots")
ELEMENT_ALIVE = Topic(
    "elements/*/alive",
    Kind.TOKEN,
    "",
    "",
    "There while the robot has the element that is named; its agent lives as long",
)

TOPICS = tuple(topic for topic in globals().values() if isinstance(topic, Topic))
"""All of them, in the order of their definitions."""
MOTIONS = (MOVE, TURN, HEADING, GRIP, REACH, LOOK)
"""Commands that set something going. Each also takes `heartbeat`, a key to which the motion is bound, and `detach`."""

_BY_SUFFIX = {topic.suffix: topic for topic in TOPICS}


def robot_name(name: str) -> str:
    """Return the name if it is valid for a robot: one chunk of a key.

    Raises:
        KeyNotValid: It is empty or too long, begins with `@`, or holds whitespace, what cannot be printed, or one of
            `/ * $ ? #`.
    """
    if len(name) > LONGEST_ROBOT_NAME:
        raise KeyNotValid(
            f"{quoted(name)} cannot name a robot because it has {len(name)} characters; "
            f"use at most {LONGEST_ROBOT_NAME}"
        )
    bad = sorted({character for character in name if character in FORBIDDEN_IN_NAMES or not character.isprintable()})
    bad += [" "] * any(character.isspace() and character.isprintable() for character in name)
    if not name or name.startswith("@") or bad:
        reason = f"holds {' '.join(map(repr, bad))}" if bad else "is empty" if not name else "begins with '@'"
        raise KeyNotValid(f"{name!r} cannot name a robot because it {reason}; use letters, digits, '_' and '-'")
    return name


def frame(robot: str, name: str) -> str:
    """Return a coordinate frame of one robot: `happy/base_link`."""
    return f"{robot}/{name}"


def split(key: str) -> tuple[str, str]:
    """Return a key's robot and suffix: `("happy", "sonar/points")`; the suffix is empty if the key has one chunk."""
    robot, _, suffix = key.partition("/")
    return robot, suffix


def topic_of(key: str) -> Topic | None:
    """Return the row of the table to which a key belongs, or None for a foreign key."""
    _, suffix = split(key)
    chunks = suffix.split("/")
    varied = ("/".join([*chunks[:at], "*", *chunks[at + 1 :]]) for at in reversed(range(len(chunks))))
    return _BY_SUFFIX.get(suffix) or next((_BY_SUFFIX[one] for one in varied if one in _BY_SUFFIX), None)

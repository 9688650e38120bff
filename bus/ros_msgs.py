"""The messages of ROS 2 Jazzy that robots and their programs exchange.

They are those of rosbags, written out: its own are made together with all of ROS, which takes each program 0.1 s.
Every field must be given; number arrays are numpy arrays of the field's own type (`covariance`: float64, shape (36,)).
Units and meaning are those of the standard. Source: the `.msg` files of ROS 2 Jazzy; a test compares them with rosbags.
"""

from dataclasses import dataclass
from typing import ClassVar

from bus.field_types import (
    Bool,
    Byte,
    Bytes,
    Float32,
    Float64,
    Floats32,
    Floats64,
    Int32,
    Ints8,
    Ints32,
    Matrix3,
    Matrix6,
    Matrix34,
    String,
    Strings,
    UInt8,
    UInt32,
)


@dataclass
class Time:
    """s and ns since 1970."""

    sec: Int32
    nanosec: UInt32
    __msgtype__: ClassVar[str] = "builtin_interfaces/msg/Time"


@dataclass
class Header:
    """When, and in which frame."""

    stamp: Time
    frame_id: String
    __msgtype__: ClassVar[str] = "std_msgs/msg/Header"


@dataclass
class KeyValue:
    """A value of a diagnosis."""

    key: String
    value: String
    __msgtype__: ClassVar[str] = "diagnostic_msgs/msg/KeyValue"


@dataclass
class DiagnosticStatus:
    """How a part of a robot is."""

    level: Byte
    name: String
    message: String
    hardware_id: String
    values: list[KeyValue]
    OK: ClassVar[int] = 0
    WARN: ClassVar[int] = 1
    ERROR: ClassVar[int] = 2
    STALE: ClassVar[int] = 3
    __msgtype__: ClassVar[str] = "diagnostic_msgs/msg/DiagnosticStatus"


@dataclass
class DiagnosticArray:
    """How all parts are."""

    header: Header
    status: list[DiagnosticStatus]
    __msgtype__: ClassVar[str] = "diagnostic_msgs/msg/DiagnosticArray"


@dataclass
class Point:
    """m."""

    x: Float64
    y: Float64
    z: Float64
    __msgtype__: ClassVar[str] = "geometry_msgs/msg/Point"


@dataclass
class Quaternion:
    """An orientation."""

    x: Float64
    y: Float64
    z: Float64
    w: Float64
    __msgtype__: ClassVar[str] = "geometry_msgs/msg/Quaternion"


@dataclass
class Pose:
    """Where something is."""

    position: Point
    orientation: Quaternion
    __msgtype__: ClassVar[str] = "geometry_msgs/msg/Pose"


@dataclass
class PoseWithCovariance:
    """Where something is, and how certain that is: x, y, z, and rotation about x, y, z."""

    pose: Pose
    covariance: Matrix6
    __msgtype__: ClassVar[str] = "geometry_msgs/msg/PoseWithCovariance"


@dataclass
class PoseWithCovarianceStamped:
    """A pose with when, and in which frame."""

    header: Header
    pose: PoseWithCovariance
    __msgtype__: ClassVar[str] = "geometry_msgs/msg/PoseWithCovarianceStamped"


@dataclass
class Vector3:
    """A direction and its size."""

    x: Float64
    y: Float64
    z: Float64
    __msgtype__: ClassVar[str] = "geometry_msgs/msg/Vector3"


@dataclass
class Transform:
    """From one frame to another."""

    translation: Vector3
    rotation: Quaternion
    __msgtype__: ClassVar[str] = "geometry_msgs/msg/Transform"


@dataclass
class TransformStamped:
    """Where a frame lies in another."""

    header: Header
    child_frame_id: String
    transform: Transform
    __msgtype__: ClassVar[str] = "geometry_msgs/msg/TransformStamped"


@dataclass
class Twist:
    """m/s and rad/s."""

    linear: Vector3
    angular: Vector3
    __msgtype__: ClassVar[str] = "geometry_msgs/msg/Twist"


@dataclass
class TwistStamped:
    """m/s and rad/s, from a time on."""

    header: Header
    twist: Twist
    __msgtype__: ClassVar[str] = "geometry_msgs/msg/TwistStamped"


@dataclass
class TwistWithCovariance:
    """m/s and rad/s, and how certain they are."""

    twist: Twist
    covariance: Matrix6
    __msgtype__: ClassVar[str] = "geometry_msgs/msg/TwistWithCovariance"


@dataclass
class Odometry:
    """Pose in `header.frame_id`, twist in `child_frame_id`."""

    header: Header
    child_frame_id: String
    pose: PoseWithCovariance
    twist: TwistWithCovariance
    __msgtype__: ClassVar[str] = "nav_msgs/msg/Odometry"


@dataclass
class BatteryState:
    """V, A, Ah and °C; NaN where it is not known."""

    header: Header
    voltage: Float32
    temperature: Float32
    current: Float32
    charge: Float32
    capacity: Float32
    design_capacity: Float32
    percentage: Float32
    power_supply_status: UInt8
    power_supply_health: UInt8
    power_supply_technology: UInt8
    present: Bool
    cell_voltage: Floats32
    cell_temperature: Floats32
    location: String
    serial_number: String
    POWER_SUPPLY_STATUS_UNKNOWN: ClassVar[int] = 0
    POWER_SUPPLY_STATUS_CHARGING: ClassVar[int] = 1
    POWER_SUPPLY_STATUS_DISCHARGING: ClassVar[int] = 2
    POWER_SUPPLY_STATUS_NOT_CHARGING: ClassVar[int] = 3
    POWER_SUPPLY_STATUS_FULL: ClassVar[int] = 4
    POWER_SUPPLY_HEALTH_UNKNOWN: ClassVar[int] = 0
    POWER_SUPPLY_HEALTH_GOOD: ClassVar[int] = 1
    POWER_SUPPLY_HEALTH_OVERHEAT: ClassVar[int] = 2
    POWER_SUPPLY_HEALTH_DEAD: ClassVar[int] = 3
    POWER_SUPPLY_HEALTH_OVERVOLTAGE: ClassVar[int] = 4
    POWER_SUPPLY_HEALTH_UNSPEC_FAILURE: ClassVar[int] = 5
    POWER_SUPPLY_HEALTH_COLD: ClassVar[int] = 6
    POWER_SUPPLY_HEALTH_WATCHDOG_TIMER_EXPIRE: ClassVar[int] = 7
    POWER_SUPPLY_HEALTH_SAFETY_TIMER_EXPIRE: ClassVar[int] = 8
    POWER_SUPPLY_TECHNOLOGY_UNKNOWN: ClassVar[int] = 0
    POWER_SUPPLY_TECHNOLOGY_NIMH: ClassVar[int] = 1
    POWER_SUPPLY_TECHNOLOGY_LION: ClassVar[int] = 2
    POWER_SUPPLY_TECHNOLOGY_LIPO: ClassVar[int] = 3
    POWER_SUPPLY_TECHNOLOGY_LIFE: ClassVar[int] = 4
    POWER_SUPPLY_TECHNOLOGY_NICD: ClassVar[int] = 5
    POWER_SUPPLY_TECHNOLOGY_LIMN: ClassVar[int] = 6
    POWER_SUPPLY_TECHNOLOGY_TERNARY: ClassVar[int] = 7
    POWER_SUPPLY_TECHNOLOGY_VRLA: ClassVar[int] = 8
    __msgtype__: ClassVar[str] = "sensor_msgs/msg/BatteryState"


@dataclass
class RegionOfInterest:
    """A part of an image, px; all 0 is the whole image."""

    x_offset: UInt32
    y_offset: UInt32
    height: UInt32
    width: UInt32
    do_rectify: Bool
    __msgtype__: ClassVar[str] = "sensor_msgs/msg/RegionOfInterest"


@dataclass
class CameraInfo:
    """A calibrated camera, px. d: distortion; k: camera matrix; r: rectification; p: projection, row by row."""

    header: Header
    height: UInt32
    width: UInt32
    distortion_model: String
    d: Floats64
    k: Matrix3
    r: Matrix3
    p: Matrix34
    binning_x: UInt32
    binning_y: UInt32
    roi: RegionOfInterest
    __msgtype__: ClassVar[str] = "sensor_msgs/msg/CameraInfo"


@dataclass
class CompressedImage:
    """A picture, in JPEG or PNG."""

    header: Header
    format: String
    data: Bytes
    __msgtype__: ClassVar[str] = "sensor_msgs/msg/CompressedImage"


@dataclass
class Imu:
    """rad/s and m/s2."""

    header: Header
    orientation: Quaternion
    orientation_covariance: Matrix3
    angular_velocity: Vector3
    angular_velocity_covariance: Matrix3
    linear_acceleration: Vector3
    linear_acceleration_covariance: Matrix3
    __msgtype__: ClassVar[str] = "sensor_msgs/msg/Imu"


@dataclass
class JointState:
    """rad or m, and likewise."""

    header: Header
    name: Strings
    position: Floats64
    velocity: Floats64
    effort: Floats64
    __msgtype__: ClassVar[str] = "sensor_msgs/msg/JointState"


@dataclass
class Joy:
    """A joystick."""

    header: Header
    axes: Floats32
    buttons: Ints32
    __msgtype__: ClassVar[str] = "sensor_msgs/msg/Joy"


@dataclass
class LaserScan:
    """rad, s and m."""

    header: Header
    angle_min: Float32
    angle_max: Float32
    angle_increment: Float32
    time_increment: Float32
    scan_time: Float32
    range_min: Float32
    range_max: Float32
    ranges: Floats32
    intensities: Floats32
    __msgtype__: ClassVar[str] = "sensor_msgs/msg/LaserScan"


@dataclass
class PointField:
    """A channel of a point cloud."""

    name: String
    offset: UInt32
    datatype: UInt8
    count: UInt32
    INT8: ClassVar[int] = 1
    UINT8: ClassVar[int] = 2
    INT16: ClassVar[int] = 3
    UINT16: ClassVar[int] = 4
    INT32: ClassVar[int] = 5
    UINT32: ClassVar[int] = 6
    FLOAT32: ClassVar[int] = 7
    FLOAT64: ClassVar[int] = 8
    __msgtype__: ClassVar[str] = "sensor_msgs/msg/PointField"


@dataclass
class PointCloud2:
    """Points, as bytes."""

    header: Header
    height: UInt32
    width: UInt32
    fields: list[PointField]
    is_bigendian: Bool
    point_step: UInt32
    row_step: UInt32
    data: Bytes
    is_dense: Bool
    __msgtype__: ClassVar[str] = "sensor_msgs/msg/PointCloud2"


@dataclass
class Range:
    """A distance sensor: rad and m."""

    header: Header
    radiation_type: UInt8
    field_of_view: Float32
    min_range: Float32
    max_range: Float32
    range: Float32
    variance: Float32
    ULTRASOUND: ClassVar[int] = 0
    INFRARED: ClassVar[int] = 1
    __msgtype__: ClassVar[str] = "sensor_msgs/msg/Range"


@dataclass
class TFMessage:
    """Frames in their parents."""

    transforms: list[TransformStamped]
    __msgtype__: ClassVar[str] = "tf2_msgs/msg/TFMessage"


@dataclass
class MapMetaData:
    """Of a grid: m of a cell's edge, cells, and the pose of the corner of cell (0, 0) in the frame of the header."""

    map_load_time: Time
    resolution: Float32
    width: UInt32
    height: UInt32
    origin: Pose
    __msgtype__: ClassVar[str] = "nav_msgs/msg/MapMetaData"


@dataclass
class OccupancyGridMessage:
    """A map in cells, row by row from the lowest y: -1 unknown, 0 free to 100 occupied."""

    header: Header
    info: MapMetaData
    data: Ints8
    __msgtype__: ClassVar[str] = "nav_msgs/msg/OccupancyGrid"


STANDARD_MESSAGES = tuple(each for each in globals().values() if hasattr(each, "__msgtype__"))
"""All of them, in the order of their definitions."""

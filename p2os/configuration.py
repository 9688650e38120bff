"""CONFIGpac: what the controller is and is set to.

Source: Pioneer 3/2 H8-series manual, CONFIGpac; its later fields as client libraries read them.
"""

from collections.abc import Mapping
from enum import IntEnum
from typing import NamedTuple

from p2os.fields import Field, Quantity


class ChargerKind(IntEnum):
    """Values of `Configuration.charger`."""

    NONE = 0
    PIONEER = 1
    POWERBOT = 2


class GyroKind(IntEnum):
    """Values of `Configuration.has_gyro`. INSIDE: the controller corrects its own heading."""

    NONE = 0
    PACKETS = 1
    INSIDE = 2


class AutoBaud(IntEnum):
    """Values of `Configuration.auto_baud`. PER_CLIENT: the rate that HOSTBAUD sets ends with the connection.

    A client library calls the byte so, starts at the old rate every time, and sends CLOSE at every rate to a robot
    that does not answer.
    """

    CHANGEABLE = 1
    PER_CLIENT = 2


CONFIGURATION = (
    Field("robot_type", "z", Quantity.TEXT),
    Field("subtype", "z", Quantity.TEXT),
    Field("serial", "z", Quantity.TEXT),
    Field("four_motors", "B", meaning="antique"),
    Field("rotation_top", "H", Quantity.ROTATION),
    Field("velocity_top", "H", Quantity.SPEED),
    Field("rotational_acceleration_top", "H", Quantity.ANGULAR_ACCELERATION),
    Field("acceleration_top", "H", Quantity.ACCELERATION),
    Field("pwm_max", "H"),
    Field("name", "z", Quantity.TEXT),
    Field("sip_cycle", "B", Quantity.DURATION),
    Field("host_baud", "B", meaning="code as in HOSTBAUD"),
    Field("aux1_baud", "B", meaning="likewise"),
    Field("gripper", "H"),
    Field("front_sonar", "H"),
    Field("rear_sonar", "B"),
    Field("low_battery", "H", Quantity.VOLTAGE),
    Field("rev_count", "H"),
    Field("watchdog", "H", Quantity.DURATION),
    Field("alternative_sip", "B"),
    Field("stall_value", "H"),
    Field("stall_count", "H", Quantity.DURATION),
    Field("joystick_velocity", "H", Quantity.SPEED),
    Field("joystick_rotation", "H", Quantity.ROTATION),
    Field("rotation_max", "H", Quantity.ROTATION),
    Field("velocity_max", "H", Quantity.SPEED),
    Field("rotational_acceleration", "H", Quantity.ANGULAR_ACCELERATION),
    Field("rotational_deceleration", "H", Quantity.ANGULAR_ACCELERATION),
    Field("rot_kp", "H"),
    Field("rot_kv", "H"),
    Field("rot_ki", "H"),
    Field("acceleration", "H", Quantity.ACCELERATION),
    Field("deceleration", "H", Quantity.ACCELERATION),
    Field("trans_kp", "H"),
    Field("trans_kv", "H"),
    Field("trans_ki", "H", meaning="P2OS packets end here"),
    Field("front_bumpers", "B"),
    Field("rear_bumpers", "B", meaning="AROS 1.6 ends here"),
    Field("charger", "B", meaning="0 none, 1 Pioneer 3, 2 PowerBot; AROS 1.7 ends here"),
    Field("sonar_cycle", "B", Quantity.DURATION),
    Field("auto_baud", "B", meaning="1 can change, 2 automatic"),
    Field("has_gyro", "B", meaning="1 by packets, 2 inside the controller; AROS 1.8 ends here"),
    Field("drift_factor", "h"),
    Field("aux2_baud", "B"),
    Field("aux3_baud", "B"),
    Field("ticks_per_mm", "H"),
    Field("shutdown_voltage", "H", Quantity.VOLTAGE),
    Field("firmware_version", "z", Quantity.TEXT),
    Field("gyro_cw", "H"),
    Field("gyro_ccw", "H"),
    Field("kinematics_delay", "B", Quantity.DURATION),
    Field("lateral_velocity_top", "H", Quantity.SPEED),
    Field("lateral_acceleration_top", "H", Quantity.ACCELERATION),
    Field("lateral_velocity_max", "H", Quantity.SPEED),
    Field("lateral_acceleration", "H", Quantity.ACCELERATION),
    Field("lateral_deceleration", "H", Quantity.ACCELERATION),
    Field("charge_threshold", "H"),
    Field("pdb_port", "B"),
    Field("gyro_rate_limit", "H"),
    Field("high_temperature_shutdown", "b", Quantity.TEMPERATURE),
    Field("power_bits", "H"),
    Field("battery_type", "B"),
    Field("charge_low", "H"),
    Field("charge_shutdown", "H"),
    Field("bootloader_version", "z", Quantity.TEXT),
    Field("configuration_flags", "I"),
    Field("gyro_firmware_version", "h"),
)


class Configuration(NamedTuple):
    """CONFIGpac: what the controller is and is set to; SI.

    The packets of older firmware end earlier: what they lack is zero or empty. Baud rates are codes as in HOSTBAUD.
    """

    robot_type: str = "Pioneer"
    subtype: str = ""
    serial: str = ""
    four_motors: int = 0
    rotation_top: float = 0.0
    velocity_top: float = 0.0
    rotational_acceleration_top: float = 0.0
    acceleration_top: float = 0.0
    pwm_max: int = 0
    name: str = ""
    sip_cycle: float = 0.0
    host_baud: int = 0
    aux1_baud: int = 0
    gripper: int = 0
    front_sonar: int = 0
    rear_sonar: int = 0
    low_battery: float = 0.0
    rev_count: int = 0
    watchdog: float = 0.0
    alternative_sip: int = 0
    stall_value: int = 0
    stall_count: float = 0.0
    joystick_velocity: float = 0.0
    joystick_rotation: float = 0.0
    rotation_max: float = 0.0
    velocity_max: float = 0.0
    rotational_acceleration: float = 0.0
    rotational_deceleration: float = 0.0
    rot_kp: int = 0
    rot_kv: int = 0
    rot_ki: int = 0
    acceleration: float = 0.0
    deceleration: float = 0.0
    trans_kp: int = 0
    trans_kv: int = 0
    trans_ki: int = 0
    front_bumpers: int = 0
    rear_bumpers: int = 0
    charger: int = 0
    sonar_cycle: float = 0.0
    auto_baud: int = 0
    has_gyro: int = 0
    drift_factor: int = 0
    aux2_baud: int = 0
    aux3_baud: int = 0
    ticks_per_mm: int = 0
    shutdown_voltage: float = 0.0
    firmware_version: str = ""
    gyro_cw: int = 0
    gyro_ccw: int = 0
    kinematics_delay: float = 0.0
    lateral_velocity_top: float = 0.0
    lateral_acceleration_top: float = 0.0
    lateral_velocity_max: float = 0.0
    lateral_acceleration: float = 0.0
    lateral_deceleration: float = 0.0
    charge_threshold: int = 0
    pdb_port: int = 0
    gyro_rate_limit: int = 0
    high_temperature_shutdown: float = 0.0
    power_bits: int = 0
    battery_type: int = 0
    charge_low: int = 0
    charge_shutdown: int = 0
    bootloader_version: str = ""
    configuration_flags: int = 0
    gyro_firmware_version: int = 0


CONFIGURATION_VARIANTS: Mapping[str, str] = {
    "P2OS 1.4": "trans_ki",
    "AROS 1.6": "rear_bumpers",
    "AROS 1.7": "charger",
    "AROS 1.8": "has_gyro",
    "ARCOS": "gyro_firmware_version",
}
"""Firmware to the last field of its CONFIGpac."""

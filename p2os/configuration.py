"""CONFIGpac: identity and settings of the controller.

Source: Pioneer 3/2 H8-series manual, CONFIGpac; its later fields as client libraries read them.
"""

from collections.abc import Mapping
from enum import IntEnum
from typing import Annotated, NamedTuple

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


class Configuration(NamedTuple):
    """CONFIGpac: identity and settings of the controller; SI.

    The packets of older firmware end earlier: what they lack is zero or empty. Baud rates are codes as in HOSTBAUD.
    """

    robot_type: Annotated[str, Field("z", Quantity.TEXT)] = "Pioneer"
    subtype: Annotated[str, Field("z", Quantity.TEXT)] = ""
    serial: Annotated[str, Field("z", Quantity.TEXT)] = ""
    four_motors: Annotated[int, Field("B", meaning="antique")] = 0
    rotation_top: Annotated[float, Field("H", Quantity.ROTATION)] = 0.0
    velocity_top: Annotated[float, Field("H", Quantity.SPEED)] = 0.0
    rotational_acceleration_top: Annotated[float, Field("H", Quantity.ANGULAR_ACCELERATION)] = 0.0
    acceleration_top: Annotated[float, Field("H", Quantity.ACCELERATION)] = 0.0
    pwm_max: Annotated[int, Field("H")] = 0
    name: Annotated[str, Field("z", Quantity.TEXT)] = ""
    sip_cycle: Annotated[float, Field("B", Quantity.DURATION)] = 0.0
    host_baud: Annotated[int, Field("B", meaning="code as in HOSTBAUD")] = 0
    aux1_baud: Annotated[int, Field("B", meaning="likewise")] = 0
    gripper: Annotated[int, Field("H")] = 0
    front_sonar: Annotated[int, Field("H")] = 0
    rear_sonar: Annotated[int, Field("B")] = 0
    low_battery: Annotated[float, Field("H", Quantity.VOLTAGE)] = 0.0
    rev_count: Annotated[int, Field("H")] = 0
    watchdog: Annotated[float, Field("H", Quantity.DURATION)] = 0.0
    alternative_sip: Annotated[int, Field("B")] = 0
    stall_value: Annotated[int, Field("H")] = 0
    stall_count: Annotated[float, Field("H", Quantity.DURATION)] = 0.0
    joystick_velocity: Annotated[float, Field("H", Quantity.SPEED)] = 0.0
    joystick_rotation: Annotated[float, Field("H", Quantity.ROTATION)] = 0.0
    rotation_max: Annotated[float, Field("H", Quantity.ROTATION)] = 0.0
    velocity_max: Annotated[float, Field("H", Quantity.SPEED)] = 0.0
    rotational_acceleration: Annotated[float, Field("H", Quantity.ANGULAR_ACCELERATION)] = 0.0
    rotational_deceleration: Annotated[float, Field("H", Quantity.ANGULAR_ACCELERATION)] = 0.0
    rot_kp: Annotated[int, Field("H")] = 0
    rot_kv: Annotated[int, Field("H")] = 0
    rot_ki: Annotated[int, Field("H")] = 0
    acceleration: Annotated[float, Field("H", Quantity.ACCELERATION)] = 0.0
    deceleration: Annotated[float, Field("H", Quantity.ACCELERATION)] = 0.0
    trans_kp: Annotated[int, Field("H")] = 0
    trans_kv: Annotated[int, Field("H")] = 0
    trans_ki: Annotated[int, Field("H", meaning="P2OS packets end here")] = 0
    front_bumpers: Annotated[int, Field("B")] = 0
    rear_bumpers: Annotated[int, Field("B", meaning="AROS 1.6 ends here")] = 0
    charger: Annotated[int, Field("B", meaning="0 none, 1 Pioneer 3, 2 PowerBot; AROS 1.7 ends here")] = 0
    sonar_cycle: Annotated[float, Field("B", Quantity.DURATION)] = 0.0
    auto_baud: Annotated[int, Field("B", meaning="1 can change, 2 automatic")] = 0
    has_gyro: Annotated[int, Field("B", meaning="1 by packets, 2 inside the controller; AROS 1.8 ends here")] = 0
    drift_factor: Annotated[int, Field("h")] = 0
    aux2_baud: Annotated[int, Field("B")] = 0
    aux3_baud: Annotated[int, Field("B")] = 0
    ticks_per_mm: Annotated[int, Field("H")] = 0
    shutdown_voltage: Annotated[float, Field("H", Quantity.VOLTAGE)] = 0.0
    firmware_version: Annotated[str, Field("z", Quantity.TEXT)] = ""
    gyro_cw: Annotated[int, Field("H")] = 0
    gyro_ccw: Annotated[int, Field("H")] = 0
    kinematics_delay: Annotated[float, Field("B", Quantity.DURATION)] = 0.0
    lateral_velocity_top: Annotated[float, Field("H", Quantity.SPEED)] = 0.0
    lateral_acceleration_top: Annotated[float, Field("H", Quantity.ACCELERATION)] = 0.0
    lateral_velocity_max: Annotated[float, Field("H", Quantity.SPEED)] = 0.0
    lateral_acceleration: Annotated[float, Field("H", Quantity.ACCELERATION)] = 0.0
    lateral_deceleration: Annotated[float, Field("H", Quantity.ACCELERATION)] = 0.0
    charge_threshold: Annotated[int, Field("H")] = 0
    pdb_port: Annotated[int, Field("B")] = 0
    gyro_rate_limit: Annotated[int, Field("H")] = 0
    high_temperature_shutdown: Annotated[float, Field("b", Quantity.TEMPERATURE)] = 0.0
    power_bits: Annotated[int, Field("H")] = 0
    battery_type: Annotated[int, Field("B")] = 0
    charge_low: Annotated[int, Field("H")] = 0
    charge_shutdown: Annotated[int, Field("H")] = 0
    bootloader_version: Annotated[str, Field("z", Quantity.TEXT)] = ""
    configuration_flags: Annotated[int, Field("I")] = 0
    gyro_firmware_version: Annotated[int, Field("h")] = 0


CONFIGURATION_VARIANTS: Mapping[str, str] = {
    "P2OS 1.4": "trans_ki",
    "AROS 1.6": "rear_bumpers",
    "AROS 1.7": "charger",
    "AROS 1.8": "has_gyro",
    "ARCOS": "gyro_firmware_version",
}
"""Firmware to the last field of its CONFIGpac."""

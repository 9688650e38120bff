"""Firmware families, and the rows in which they differ.

Source: Pioneer 2 (P2OS), Pioneer 3/2 H8-series (AROS) and Pioneer 3 (ARCOS) operations manuals. The subsets of uARCS
and AmigOS are not documented: they are treated as ARCOS and AROS.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import StrEnum
from math import radians


class Family(StrEnum):
    """The line of firmware in a robot's microcontroller."""

    P2OS = "P2OS"
    AROS = "AROS"
    ARCOS = "ARCOS"
    AMIGOS = "AmigOS"
    UARCS = "uARCS"


@dataclass(frozen=True, slots=True)
class FlashDefaults:
    """What a controller's FLASH holds when it leaves the factory; SI.

    Source: FLASH parameter table of the Pioneer 3/2 H8-series manual; `assumed` marks what it does not say.
    sonar_cycle: s between two firings of one array. stall_value: in PWM units; above `pwm_max` it would never stall.
    bump_stall: as the BUMPSTALL command counts: 0 none, 1 front, 2 rear, 3 both.
    auto_baud: as CONFIGpac says: 1 the host may change the rate, 2 it should do so by itself, for one connection.
    low_battery, shutdown_battery: fractions of the nominal voltage.
    """

    sip_cycle: float = 0.1
    sonar_cycle: float = 0.04
    watchdog: float = 2.0
    host_baud: int = 9600
    aux_baud: int = 9600
    auto_baud: int = 1
    acceleration: float = 0.3
    deceleration: float = 0.3
    rotational_acceleration: float = radians(100)  # assumed, the limit that clients fall back to
    rotational_deceleration: float = radians(100)  # assumed, likewise
    acceleration_top: float = 2.0  # assumed
    rotational_acceleration_top: float = radians(300)  # assumed
    rot_kp: int = 30
    rot_kv: int = 200
    rot_ki: int = 0
    trans_kp: int = 15
    trans_kv: int = 450
    trans_ki: int = 4
    joystick_velocity: float = 1.0
    joystick_rotation: float = radians(50)
    pwm_max: int = 500  # assumed
    stall_value: int = 200  # assumed
    stall_count: float = 0.2  # assumed: s without power after a stall
    stall_integration: float = 0.5
    stall_below: float = 0.1
    low_battery: float = 11.0 / 12.0  # assumed: where one well-known driver reports an error
    shutdown_battery: float = 10.0 / 12.0  # assumed
    bump_stall: int = 3
    e_stall: bool = True
    kinematics_delay: float = 0.0


@dataclass(frozen=True, slots=True)
class Firmware:
    """One family's rows.

    version: as CONFIGpac says. last_sip_field, last_configuration_field: where its packets end, by the packet tables.
    """

    family: Family
    version: str
    last_sip_field: str
    last_configuration_field: str
    flash: FlashDefaults


_P2OS = Firmware(
    Family.P2OS,
    version="1.M",
    last_sip_field="digital_out",
    last_configuration_field="trans_ki",
    flash=FlashDefaults(bump_stall=0, e_stall=False),
)
_AROS = replace(_P2OS, family=Family.AROS, version="1.8", last_configuration_field="has_gyro", flash=FlashDefaults())
_ARCOS = replace(
    _AROS,
    family=Family.ARCOS,
    version="2.8",
    last_sip_field="fault_flags",
    last_configuration_field="gyro_firmware_version",
)

FIRMWARES: Mapping[Family, Firmware] = {
    row.family: row
    for row in (
        _P2OS,
        _AROS,
        _ARCOS,
        replace(_AROS, family=Family.AMIGOS),
        replace(_ARCOS, family=Family.UARCS),
    )
}
"""What each firmware family does differently."""

BAUD_CODES: Mapping[int, int] = {0: 9600, 1: 19200, 2: 38400, 3: 57600, 4: 115200}
"""Argument of HOSTBAUD and AUXnBAUD, and baud fields of CONFIGpac, to bit/s. Source: Pioneer 3 operations manual."""

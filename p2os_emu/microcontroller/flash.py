"""FLASH: the parameters that survive disconnecting and switching off."""

from base64 import b32encode
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from hashlib import sha256
from math import radians
from typing import Any

from p2os.arguments import StallBumpers
from p2os.firmware import BAUD_CODES, FlashDefaults
from p2os.robot_model import RobotModel

Entry = float | str

BUMP_STALL = "bump_stall"


ABOVE_ZERO = (
    "sip_cycle",
    "acceleration",
    "deceleration",
    "rotational_acceleration",
    "rotational_deceleration",
    "emergency_deceleration",
    "emergency_rotational_deceleration",
    "pwm_max",
    "stall_integration",
    "ticks_mm",
    "rev_count",
)
"""Parameters that the firmware divides by, or without which the robot could not come to a stand."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Flash(FlashDefaults):
    """One robot's FLASH; SI. The factory defaults, and the values of this robot.

    serial: as CONFIGpac says; never "SIM", which makes one well-known client look for a simulator.
    velocity_top, rotation_top: what no command exceeds. max_velocity, max_rotation: SETV and SETRV at power-on.
    emergency_deceleration, emergency_rotational_deceleration: of ESTOP and the STOP button
        (assumed: the most that the motors can follow).
    sonar_enabled: the sonar fires from OPEN on.
    ticks_mm, rev_count, drift_factor: the calibration that odometry starts from. Manuals disagree on what REVCOUNT
    counts, so only its changes matter and its value is assumed.

    Raises:
        ValueError: A parameter has a value that no controller could run with.
    """

    serial: str
    velocity_top: float
    rotation_top: float
    max_velocity: float
    max_rotation: float
    emergency_deceleration: float = 2.0
    emergency_rotational_deceleration: float = radians(300)
    sonar_enabled: bool = True
    ticks_mm: int
    rev_count: int = 32550
    drift_factor: int = 0

    def __post_init__(self) -> None:
        for name in ABOVE_ZERO:
            if not getattr(self, name) > 0:
                raise ValueError(f"FLASH parameter {name} must be above zero, not {getattr(self, name)}")
        for baud in (self.host_baud, self.aux_baud):
            if baud not in BAUD_CODES.values():
                raise ValueError(f"FLASH knows the baud rates {sorted(BAUD_CODES.values())}, not {baud}")

    @classmethod
    def of(cls, model: RobotModel, name: str, seed: int = 0) -> "Flash":
        """Return the factory settings of a robot of this model; its serial number follows from name and seed."""
        return cls(
            **asdict(model.flash),
            serial=_serial_number(name, seed),
            velocity_top=model.max_velocity,
            rotation_top=model.max_rotation,
            max_velocity=model.max_velocity,
            max_rotation=model.max_rotation,
            ticks_mm=max(1, round(model.ticks_per_metre / 1000)),
        )

    def to_table(self) -> dict[str, Entry]:
        """Every parameter by name, for a file; BumpStall as FLASH counts it: 0 both, 1 rear, 2 front, 3 none."""
        return {**asdict(self), BUMP_STALL: int(self.bump_stall ^ StallBumpers.BOTH)}

    def changed(self, table: Mapping[str, Entry]) -> "Flash":
        """This FLASH with some parameters replaced, as `to_table` names and counts them.

        Raises:
            ValueError: A name is unknown, or a value is none that the parameter can have.
        """
        present = self.to_table()
        for name, value in table.items():
            if name not in present:
                raise ValueError(f"FLASH has no parameter {name!r}; it has {', '.join(present)}")
            kind = type(present[name])
            if type(value) is not kind and not (kind is float and type(value) is int):
                raise ValueError(f"FLASH parameter {name} must be {kind.__name__}, not {value!r}")
            present[name] = kind(value)
        bump_stall = int(int(present.pop(BUMP_STALL)) ^ StallBumpers.BOTH)
        values: dict[str, Any] = present
        return Flash(**values, bump_stall=bump_stall)


def _serial_number(name: str, seed: int) -> str:
    """Return ACR and eight letters or digits: 40 bits of a hash, so that a million robots hardly share one."""
    return "ACR" + b32encode(sha256(f"{seed} {name}".encode()).digest()[:5]).decode()

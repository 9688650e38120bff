"""What the robot's packets say, in wire counts, taken apart by the suite's own hand.

Offsets and order: Pioneer 3 operations manual, tables 7 to 10, and ARIA's readers of the same packets.
"""

from dataclasses import dataclass
from typing import NamedTuple, Self

STANDARD = (0x32, 0x33)  # stopped, moving
CONFIGPAC, ENCODERPAC, IOPAC = 0x20, 0x90, 0xF0


def unsigned(data: bytes) -> int:
    """Little-endian bytes as a number of zero or more."""
    return sum(byte << 8 * i for i, byte in enumerate(data))


def signed(data: bytes) -> int:
    """Little-endian bytes as a number in two's complement."""
    value = unsigned(data)
    half = 1 << 8 * len(data) - 1
    return value - 2 * half if value >= half else value


def turn_between(start: int, end: int) -> int:
    """Shortest turn from one heading to another, counts of 1/4096 turn, counter-clockwise positive."""
    return (end - start + 2048) % 4096 - 2048


def travel_between(start: int, end: int) -> int:
    """Shortest way from one 15-bit position counter to another, counts."""
    return (end - start + 16384) % 32768 - 16384


class Reading(NamedTuple):
    """One sonar reading: the disc's number and the range in counts."""

    number: int
    range: int


@dataclass(frozen=True, slots=True)
class Sip:
    """A standard server information packet in wire counts; `tail` is what follows the digital outputs."""

    moving: bool
    x: int
    y: int
    heading: int
    left: int
    right: int
    battery: int
    rear_byte: int
    front_byte: int
    control: int
    flags: int
    compass: int
    sonar: tuple[Reading, ...]
    analog_port: int
    analog: int
    digital_in: int
    digital_out: int
    tail: bytes

    @staticmethod
    def is_one(payload: bytes) -> bool:
        """Whether a payload is a standard SIP."""
        return payload[0] in STANDARD

    @classmethod
    def parse(cls, payload: bytes) -> Self:
        """Take a payload apart.

        Raises:
            AssertionError: It is shorter than its own sonar count says.
        """
        assert len(payload) >= 20, f"SIP too short: {payload.hex(' ')}"
        after = 20 + 3 * payload[19]
        assert len(payload) >= after + 5, f"SIP shorter than its sonar count says: {payload.hex(' ')}"
        sonar = tuple(Reading(payload[i], unsigned(payload[i + 1 : i + 3])) for i in range(20, after, 3))
        return cls(
            moving=payload[0] == 0x33,
            x=unsigned(payload[1:3]),
            y=unsigned(payload[3:5]),
            heading=signed(payload[5:7]),
            left=signed(payload[7:9]),
            right=signed(payload[9:11]),
            battery=payload[11],
            rear_byte=payload[12],
            front_byte=payload[13],
            control=signed(payload[14:16]),
            flags=unsigned(payload[16:18]),
            compass=payload[18],
            sonar=sonar,
            analog_port=payload[after + 1],
            analog=payload[after + 2],
            digital_in=payload[after + 3],
            digital_out=payload[after + 4],
            tail=payload[after + 5 :],
        )

    @property
    def motors(self) -> bool:
        """Motors enabled."""
        return bool(self.flags & 1)

    @property
    def arrays(self) -> set[int]:
        """Sonar arrays enabled, counted from 1."""
        return {array for array in range(1, 5) if self.flags >> array & 1}

    @property
    def at_rest(self) -> bool:
        """Both wheels reported still."""
        return not self.left and not self.right and not self.moving


# Name and kind in the order ARIA reads them: s string ending with NUL, u1 u2 u4 unsigned, i1 i2 signed bytes.
CONFIGURATION_LAYOUT = """
    robot_class:s subtype:s serial:s four_motors:u1
    rot_vel_top:u2 trans_vel_top:u2 rot_acc_top:u2 trans_acc_top:u2 pwm_max:u2
    name:s sip_cycle:u1 host_baud:u1 aux1_baud:u1 gripper:u2 front_sonar:u2 rear_sonar:u1
    low_battery:u2 rev_count:u2 watchdog:u2 p2_packets:u1 stall_value:u2 stall_count:u2 joy_vel:u2 joy_rvel:u2
    rot_vel_max:u2 trans_vel_max:u2 rot_acc:u2 rot_decel:u2 rot_kp:u2 rot_kv:u2 rot_ki:u2
    trans_acc:u2 trans_decel:u2 trans_kp:u2 trans_kv:u2 trans_ki:u2
    front_bumpers:u1 rear_bumpers:u1 charger:u1 sonar_cycle:u1 auto_baud:u1 has_gyro:u1
    drift_factor:i2 aux2_baud:u1 aux3_baud:u1 ticks_mm:u2 shutdown_volts:u2 firmware_version:s
    gyro_cw:u2 gyro_ccw:u2 kinematics_delay:u1
    lat_vel_top:u2 lat_acc_top:u2 lat_vel_max:u2 lat_acc:u2 lat_decel:u2
    charge_threshold:u2 pdb_port:u1 gyro_rate_limit:u2 high_temperature:i1 power_bits:u2
    battery_type:u1 charge_low:u2 charge_shutdown:u2 bootloader_version:s config_flags:u4 gyro_firmware:i2
"""
CONFIGURATION = tuple((name, kind) for name, _, kind in (item.partition(":") for item in CONFIGURATION_LAYOUT.split()))


def parse_configuration(payload: bytes) -> dict[str, int | str]:
    """The fields of a CONFIGpac up to where it ends; absent ones are left out.

    Raises:
        AssertionError: It is no CONFIGpac, or ends inside a field.
    """
    assert payload[0] == CONFIGPAC, payload.hex(" ")
    fields: dict[str, int | str] = {}
    at = 1
    for name, kind in CONFIGURATION:
        if at == len(payload):
            return fields
        if kind == "s":
            end = payload.find(b"\0", at)
            assert end >= 0, f"{name} has no NUL: {payload[at:]!r}"
            fields[name] = payload[at:end].decode("ascii")
            at = end + 1
        else:
            size = int(kind[1])
            assert at + size <= len(payload), f"the packet ends inside {name}"
            fields[name] = (signed if kind[0] == "i" else unsigned)(payload[at : at + size])
            at += size
    assert at == len(payload), f"{len(payload) - at} bytes after the last field"
    return fields


def parse_encoders(payload: bytes) -> tuple[int, int]:
    """Left and right counts of an ENCODERpac."""
    assert payload[0] == ENCODERPAC, payload.hex(" ")
    assert len(payload) == 9, payload.hex(" ")
    return signed(payload[1:5]), signed(payload[5:9])


class InputsOutputs(NamedTuple):
    """An IOpac's groups."""

    digital_in: bytes
    digital_out: bytes
    analog: tuple[int, ...]


def parse_inputs_outputs(payload: bytes) -> InputsOutputs:
    """The three groups of an IOpac; each is led by its count, and the packet ends with the last word."""
    assert payload[0] == IOPAC, payload.hex(" ")
    rest = payload[1:]
    digital_in, rest = rest[1 : 1 + rest[0]], rest[1 + rest[0] :]
    digital_out, rest = rest[1 : 1 + rest[0]], rest[1 + rest[0] :]
    assert len(rest) == 1 + 2 * rest[0], f"{rest[0]} analog words announced, {len(rest) - 1} bytes follow"
    return InputsOutputs(digital_in, digital_out, tuple(unsigned(rest[i : i + 2]) for i in range(1, len(rest), 2)))

"""Packets from the robot: their types, and how each of them is laid out.

Source: Pioneer 3 operations manual (ENCODERpac, IOpac); the other packets say theirs where their classes are.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum
from typing import Annotated, Any, NamedTuple

from p2os.accessory_packets import (
    ArmInformation,
    ArmReport,
    AuxData,
    BatteryReport,
    CompassReport,
    GripperReport,
    GyroReport,
    InfraredScan,
    JoystickReport,
    MtxPacket,
    PlaylistEntry,
    Reset,
)
from p2os.configuration import Configuration
from p2os.errors import DecodeError, check_bytes
from p2os.fields import Field, Quantity, Ring, fields_of
from p2os.firmware import FIRMWARES
from p2os.packing import pack, unpack
from p2os.robot_model import RobotModel, check_model
from p2os.simulator_packets import (
    SIMULATOR_STATE,
    ExtendedLaser,
    MapChanged,
    SimulatedLaser,
    SimulatorDevice,
    SimulatorState,
)
from p2os.sip import COUNT, HEAD, SIP_TYPES, SONAR, TAIL, SipCodec, StandardSip


class PacketType(IntEnum):
    """First payload byte of a robot's packets."""

    SYNC0 = 0x00
    SYNC1 = 0x01
    SYNC2 = 0x02
    INFRARED = 0x10
    CONFIGURATION = 0x20
    SIP_STOPPED = 0x32
    SIP_MOVING = 0x33
    LASER = 0x60
    LASER_EXTENDED = 0x61
    SIMULATOR_STATE = 0x62
    SIMULATOR_DEVICE = 0x64
    MAP_CHANGED = 0x66
    ACCELERATION = 0x7B
    TORQUE = 0x7C
    ENCODERS = 0x90
    HEADING = 0x95
    GYRO = 0x98
    IMU = 0x9A
    ARM = 0xA0
    ARM_INFO = 0xA1
    AUX1 = 0xB0
    AUX2 = 0xB8
    COMPASS = 0xC0
    AUX3 = 0xC8
    PLAYLIST = 0xD0
    DEBUG_TEXT = 0xD3
    ABSOLUTE_MAXES = 0xD5
    SAFETY_STATE = 0xD6
    SAFETY_WARNING = 0xD9
    WHEELS = 0xDA
    GRIPPER = 0xE0
    INPUTS_OUTPUTS = 0xF0
    JOYSTICK = 0xF8
    BATTERY = 0xFA
    RESET_WITH_DATA = 0xFE
    RESET = 0xFF


TICK_RING = Ring(-(1 << 31), 1 << 32)
"""Ticks after which the counters of an ENCODERpac roll over."""


class Encoders(NamedTuple):
    """ENCODERpac: accumulated encoder ticks, 32 bits with sign, rolling over."""

    left: Annotated[int, Field("i", bound=TICK_RING, meaning="ticks")]
    right: Annotated[int, Field("i", bound=TICK_RING, meaning="ticks")]


INFRARED_BYTE = 3
"""Index of the infrared sensors in `IoReport.digital_in`."""


class IoReport(NamedTuple):
    """IOpac: digital ports as bytes, analog inputs in V.

    On ARCOS the input bytes are user inputs, front bumpers, rear bumpers and infrared sensors (active low).
    """

    digital_in: Annotated[bytes, Field("*s")]
    digital_out: Annotated[bytes, Field("*s")]
    analog: Annotated[tuple[float, ...], Field("*H", Quantity.ANALOG_10)]


class UnknownPacket(NamedTuple):
    """A sound frame of a type that this package does not read."""

    packet_type: int
    body: bytes


Packet = (
    StandardSip
    | Configuration
    | Encoders
    | IoReport
    | GyroReport
    | JoystickReport
    | GripperReport
    | CompassReport
    | ArmReport
    | ArmInformation
    | AuxData
    | PlaylistEntry
    | BatteryReport
    | InfraredScan
    | SimulatedLaser
    | ExtendedLaser
    | SimulatorState
    | SimulatorDevice
    | MapChanged
    | Reset
    | MtxPacket
    | UnknownPacket
)
"""Everything that `decode_packet` returns."""


@dataclass(frozen=True, slots=True)
class _PacketLayout:
    """How one packet is laid out.

    packet: its class, whose annotations are the fields. name: for people. grows: firmware has lengthened it, so one
    that ends early is read all the same.
    """

    packet: Any
    name: str
    grows: bool = False

    @property
    def fields(self) -> tuple[Field, ...]:
        """Its fields in order."""
        return fields_of(self.packet)


LAYOUTS: Mapping[int, _PacketLayout] = {
    PacketType.INFRARED: _PacketLayout(InfraredScan, "IRRF packet"),
    PacketType.CONFIGURATION: _PacketLayout(Configuration, "CONFIGpac", grows=True),
    PacketType.LASER: _PacketLayout(SimulatedLaser, "simulated laser packet"),
    PacketType.LASER_EXTENDED: _PacketLayout(ExtendedLaser, "extended laser packet"),
    PacketType.SIMULATOR_DEVICE: _PacketLayout(SimulatorDevice, "simulator device packet"),
    PacketType.MAP_CHANGED: _PacketLayout(MapChanged, "map packet"),
    PacketType.ENCODERS: _PacketLayout(Encoders, "ENCODERpac"),
    PacketType.GYRO: _PacketLayout(GyroReport, "GYROpac"),
    PacketType.ARM: _PacketLayout(ArmReport, "ARMpac"),
    PacketType.ARM_INFO: _PacketLayout(ArmInformation, "ARMINFOpac"),
    PacketType.COMPASS: _PacketLayout(CompassReport, "TCM2pac"),
    PacketType.PLAYLIST: _PacketLayout(PlaylistEntry, "PLAYLISTpac"),
    PacketType.GRIPPER: _PacketLayout(GripperReport, "GRIPPERpac"),
    PacketType.INPUTS_OUTPUTS: _PacketLayout(IoReport, "IOpac", grows=True),
    PacketType.JOYSTICK: _PacketLayout(JoystickReport, "JOYSTICKpac"),
    PacketType.BATTERY: _PacketLayout(BatteryReport, "battery packet"),
}
"""The packets that are no more than their fields, by type."""

AUX_PORTS: Mapping[int, int] = {PacketType.AUX1: 1, PacketType.AUX2: 2, PacketType.AUX3: 3}
"""SERAUXpacs by type: the port that the bytes came in at."""

RESETS = frozenset({PacketType.RESET, PacketType.RESET_WITH_DATA})

MTX_TYPES = frozenset(
    {
        PacketType.ACCELERATION,
        PacketType.TORQUE,
        PacketType.HEADING,
        PacketType.IMU,
        PacketType.DEBUG_TEXT,
        PacketType.ABSOLUTE_MAXES,
        PacketType.SAFETY_STATE,
        PacketType.SAFETY_WARNING,
        PacketType.WHEELS,
    }
)
"""Packets of MTX and Seekur controllers, which are handed on unread."""

TABLES: Mapping[int, tuple[Field, ...]] = {
    **{packet_type: layout.fields for packet_type, layout in LAYOUTS.items()},
    PacketType.SIP_STOPPED: (*HEAD, COUNT, *SONAR, *TAIL),
    PacketType.SIP_MOVING: (*HEAD, COUNT, *SONAR, *TAIL),
    PacketType.SIMULATOR_STATE: SimulatorState.fields(~0),
    **dict.fromkeys(AUX_PORTS, fields_of(AuxData)),
    PacketType.RESET_WITH_DATA: fields_of(Reset),
    PacketType.RESET: fields_of(Reset),
}
"""The packets that this package reads and writes, by type; in a SIP the two rows of a sonar reading repeat."""

_BY_CLASS = {layout.packet: (packet_type, layout) for packet_type, layout in LAYOUTS.items()}
_AUX_TYPE = {port: packet_type for packet_type, port in AUX_PORTS.items()}


def encode_packet(packet: Packet, model: RobotModel, last_field: str | None = None) -> bytes:
    """Write a packet as the model's firmware does.

    Args:
        packet: What to write.
        model: Gives scales and firmware family.
        last_field: The last field of a CONFIGpac, if it is not the one of the firmware family; see
            `CONFIGURATION_VARIANTS`.
    Returns:
        The payload of its frame.
    Raises:
        EncodeError: A value does not fit its field, or is of another type.
        TypeError: `packet` is not a packet, or `model` not a `RobotModel`.
    """
    check_model(model)
    match packet:
        case StandardSip():
            return SipCodec(model).encode(packet)
        case Configuration():
            last = last_field or FIRMWARES[model.firmware].last_configuration_field
            fields = fields_of(Configuration)[: Configuration._fields.index(last) + 1]
            return bytes([PacketType.CONFIGURATION]) + pack(fields, packet[: len(fields)], model.scales)
        case AuxData(port, data):
            return bytes([_AUX_TYPE[port]]) + data
        case Reset(data):
            return bytes([PacketType.RESET_WITH_DATA if data else PacketType.RESET]) + data
        case SimulatorState():
            fields = SimulatorState.fields(packet.flags)
            values = [getattr(packet, field.name) for field in fields]
            return bytes([PacketType.SIMULATOR_STATE]) + pack(fields, values, model.scales)
        case UnknownPacket(packet_type, body) | MtxPacket(packet_type, body):
            return bytes([packet_type]) + body
    if type(packet) not in _BY_CLASS:
        raise TypeError(f"packet must be one of the packet classes of p2os, not {packet!r}")
    packet_type, layout = _BY_CLASS[type(packet)]
    return bytes([packet_type]) + pack(layout.fields, packet, model.scales)


def decode_packet(payload: bytes, model: RobotModel, codec: SipCodec | None = None) -> Packet:
    """Read the payload of a frame from a robot.

    Args:
        payload: At least one byte, as `Frame` has it.
        model: Gives the scales.
        codec: The model's SIP codec; keep one where SIPs come often, it compiles their layouts once.
    Raises:
        DecodeError: The payload is empty, or a packet of a fixed size ends too early.
        TypeError: `payload` is not bytes, or `model` not a `RobotModel`.
    """
    check_bytes("payload", payload)
    check_model(model)
    if not payload:
        raise DecodeError("the payload is empty; a packet begins with its type")
    packet_type, body = payload[0], payload[1:]
    if packet_type in SIP_TYPES:
        return (codec or SipCodec(model)).decode(payload)
    layout = LAYOUTS.get(packet_type)
    if layout is not None:
        packet: Packet = layout.packet(*_unpacked(layout.fields, body, model, layout.name, layout.grows))
        return packet
    if packet_type in AUX_PORTS:
        return AuxData(AUX_PORTS[packet_type], body)
    if packet_type in RESETS:
        return Reset(body)
    if packet_type == PacketType.SIMULATOR_STATE:
        return _decode_simulator_state(body, model)
    return MtxPacket(packet_type, body) if packet_type in MTX_TYPES else UnknownPacket(packet_type, body)


def _decode_simulator_state(body: bytes, model: RobotModel) -> SimulatorState:
    head = SimulatorState.of(SIMULATOR_STATE, unpack(SIMULATOR_STATE, body, model.scales).values)
    fields = SimulatorState.fields(head.flags)
    return SimulatorState.of(fields, _unpacked(fields, body, model, "SIMSTAT packet", grows=False))


def _unpacked(fields: tuple[Field, ...], body: bytes, model: RobotModel, name: str, grows: bool) -> list[Any]:
    values, is_whole = unpack(fields, body, model.scales)
    if not (is_whole or grows):
        raise DecodeError(f"{name} of {len(body)} bytes ends before its last field does")
    return values

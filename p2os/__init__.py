"""The ActivMedia wire protocol (P2OS, AROS, ARCOS), both directions; no port, no clock.

Bytes and time come from the caller; everything above is in SI and radians.
"""

from p2os.accessory_packets import (
    ArmInformation,
    ArmJoint,
    ArmReport,
    ArmStatus,
    AuxData,
    BatteryReport,
    CompassReport,
    GripperReport,
    GyroReport,
    GyroSample,
    InfraredScan,
    JoystickReport,
    MtxPacket,
    PlaylistEntry,
    Reset,
)
from p2os.command_table import COMMANDS, Argument, Command
from p2os.commands import CommandValue, ReceivedCommand, decode_command, encode_command
from p2os.configuration import Configuration
from p2os.errors import DecodeError, EncodeError, LocalProtocolError, P2OSError
from p2os.fields import Field, Quantity, Scales
from p2os.firmware import BAUD_CODES, FIRMWARES, Family, Firmware, FlashDefaults
from p2os.framing import PARTIAL_TIMEOUT, Damage, Damaged, Frame, FrameDecoder, checksum, encode_frame
from p2os.handshake import ConnectionState, HostHandshake, Identity, RobotHandshake
from p2os.odometry import OdometryUnwrapper
from p2os.packets import (
    Encoders,
    IoReport,
    Packet,
    PacketType,
    UnknownPacket,
    decode_packet,
    encode_packet,
)
from p2os.robot_model import InfraredSensor, LaserMount, RobotModel, SonarDisc
from p2os.simulator_packets import (
    SIMULATOR_NAMES,
    SIMULATOR_SERIAL,
    ExtendedLaser,
    MapChanged,
    SimulatedLaser,
    SimulatedLaserReading,
    SimulatorDevice,
    SimulatorState,
)
from p2os.sip import SipCodec, SipFlag, StandardSip, stall_word

__all__ = [
    "BAUD_CODES",
    "COMMANDS",
    "FIRMWARES",
    "PARTIAL_TIMEOUT",
    "SIMULATOR_NAMES",
    "SIMULATOR_SERIAL",
    "Argument",
    "ArmInformation",
    "ArmJoint",
    "ArmReport",
    "ArmStatus",
    "AuxData",
    "BatteryReport",
    "Command",
    "CommandValue",
    "CompassReport",
    "Configuration",
    "ConnectionState",
    "Damage",
    "Damaged",
    "DecodeError",
    "EncodeError",
    "Encoders",
    "ExtendedLaser",
    "Family",
    "Field",
    "Firmware",
    "FlashDefaults",
    "Frame",
    "FrameDecoder",
    "GripperReport",
    "GyroReport",
    "GyroSample",
    "HostHandshake",
    "Identity",
    "InfraredScan",
    "InfraredSensor",
    "IoReport",
    "JoystickReport",
    "LaserMount",
    "LocalProtocolError",
    "MapChanged",
    "MtxPacket",
    "OdometryUnwrapper",
    "P2OSError",
    "Packet",
    "PacketType",
    "PlaylistEntry",
    "Quantity",
    "ReceivedCommand",
    "Reset",
    "RobotHandshake",
    "RobotModel",
    "Scales",
    "SimulatedLaser",
    "SimulatedLaserReading",
    "SimulatorDevice",
    "SimulatorState",
    "SipCodec",
    "SipFlag",
    "SonarDisc",
    "StandardSip",
    "UnknownPacket",
    "checksum",
    "decode_command",
    "decode_packet",
    "encode_command",
    "encode_frame",
    "encode_packet",
    "stall_word",
]

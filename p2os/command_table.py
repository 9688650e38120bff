"""The command table: number, name, argument, quantity, meaning, since when, and where that is written.

Since: `P2` P2OS, `A` AROS, `C` ARCOS with the version that brought a command in, where a manual says so.

Sources:
    P2 manual       Pioneer 2 and PeopleBot operations manual (P2OS)
    H8 manual       Pioneer 3 and 2 H8-series manual (AROS)
    P3 manual       Pioneer 3 operations manual (ARCOS)
    Amigo manual    AmigoBot technical manual
    client library  the commands that ARIA and Player send
"""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum, IntEnum

from p2os.fields import Quantity
from p2os.firmware import Family
from p2os.since import Since


class Argument(Enum):
    """What follows the command number."""

    NONE = "no argument"
    INT = "an int"
    UINT = "an unsigned int"
    STRING = "a string"
    TWO_BYTES = "two bytes"
    DATA = "raw data"


@dataclass(frozen=True, slots=True)
class CommandSpec:
    """One row of the command table."""

    number: int
    name: str
    argument: Argument
    quantity: Quantity
    meaning: str
    since: Since
    source: str


class Command(IntEnum):
    """Command numbers; PULSE, OPEN and CLOSE share theirs with the handshake."""

    SYNC0 = 0
    PULSE = 0
    SYNC1 = 1
    OPEN = 1
    SYNC2 = 2
    CLOSE = 2
    POLLING = 3
    ENABLE = 4
    SETA = 5
    SETV = 6
    SETO = 7
    MOVE = 8
    ROTATE = 9
    SETRV = 10
    VEL = 11
    HEAD = 12
    DHEAD = 13
    SETRV_DIRECTIONAL = 14
    SAY = 15
    JOYREQUEST = 17
    CONFIG = 18
    ENCODER = 19
    SETRVDIR = 20
    RVEL = 21
    DCHEAD = 22
    SETRA = 23
    IMUREQUEST = 26
    SONAR = 28
    STOP = 29
    DIGOUT = 30
    SETPBIOPORT = 31
    VEL2 = 32
    GRIPPER = 33
    ADSEL = 35
    GRIPPERVAL = 36
    GRIPREQUEST = 37
    GYROCALCW = 38
    GYROCALCCW = 39
    IOREQUEST = 40
    PTUPOS = 41
    TTY2 = 42
    GETAUX = 43
    BUMPSTALL = 44
    TCM2 = 45
    DOCK = 46
    JOYDRIVE = 47
    SONARCYCLE = 48
    MOVINGBLINK = 49
    HOSTBAUD = 50
    AUX1BAUD = 51
    AUX2BAUD = 52
    AUX3BAUD = 53
    ESTOP = 55
    ESTALL = 56
    ESTOP_ALIAS = 57
    GYRO = 58
    LCDWRITE = 59
    TTY4 = 60
    GETAUX3 = 61
    BATTERYINFO = 62
    LOADWORLD = 63
    STEP = 64
    CALCOMP = 65
    TTY3 = 66
    GETAUX2 = 67
    CHARGE = 68
    RESETSIMTOORIGIN = 69
    ARM_INFO = 70
    ARM_STATUS = 71
    ARM_INIT = 72
    ARM_CHECK = 73
    ARM_POWER = 74
    ARM_HOME = 75
    ARM_PARK = 76
    ARM_POS = 77
    ARM_SPEED = 78
    ARM_STOP = 79
    ARM_AUTOPARK = 80
    ARM_GRIPPARK = 81
    ROTKP = 82
    ROTKV = 83
    ROTKI = 84
    TRANSKP = 85
    TRANSKV = 86
    TRANSKI = 87
    REVCOUNT = 88
    DRIFTFACTOR = 89
    SOUND = 90
    PLAYLIST = 91
    SOUNDTOG = 92
    TICKSMM = 93
    POWER_PC = 95
    POWER_LRF = 96
    POWER_5V = 97
    POWER_12V = 98
    LATVEL = 110
    LATACCEL = 113
    RECENTERWHEELS = 120
    ACCELINFO = 123
    TORQUEINFO = 124
    POWER_AUX_PC = 125
    POWER_TOUCHSCREEN = 126
    POWER_PTZ = 127
    POWER_AUDIO = 128
    POWER_LRF2 = 129
    HEADINGINFO = 149
    ROTVEL_CLOSEDLOOP_ENABLE = 150
    SRECORD = 210
    MARCDEBUG = 211
    WHEEL_LIGHT = 212
    ABSOLUTE_MAXES = 213
    SAFETY_STATE_INFO = 214
    SAFETY_SET_STATE = 215
    SAFETY_DISABLE_POWER_OFF_TIMER = 216
    SAFETY_ZONE_ACTIVE = 217
    WHEELINFO_REQUEST = 218
    MARC_CONFIG_SET = 219
    MARC_CONFIG_GET = 220
    SIM_SET_POSE = 224
    SIM_RESET = 225
    SIM_MODEL_CONFIG = 226
    SIM_LRF_ENABLE = 230
    SIM_LRF_SET_FOV_START = 231
    SIM_LRF_SET_FOV_END = 232
    SIM_LRF_SET_RES = 233
    SIM_CTRL = 236
    SIM_STAT = 237
    SIM_MESSAGE = 238
    SIM_EXIT = 239
    BATTEST = 250
    SHUTDOWN = 250
    DIGTEMPTEST = 251
    SPOOFANALOGTEMP = 252
    RESET = 253
    MAINTENANCE = 255


# Short names, so that a row of the table stays a line.
_NONE, _INT, _UINT, _STRING, _BYTES, _DATA = Argument
_ACCELERATION = Quantity.ACCELERATION
_ANGLE = Quantity.ANGLE
_ANGULAR_ACCELERATION = Quantity.ANGULAR_ACCELERATION
_COUNT = Quantity.COUNT
_DURATION = Quantity.DURATION
_LENGTH = Quantity.LENGTH
_ROTATION = Quantity.ROTATION
_SPEED = Quantity.SPEED
_VOLTAGE = Quantity.VOLTAGE
_MANUALS = "P2, H8 and P3 manuals"
_P2_H8 = "P2 and H8 manuals"
_H8 = "H8 manual"
_P2 = "P2 manual"
_NOTES = "ARCOS 2.8 release notes"
_P3 = "P3 manual"
_LIBRARY = "client library"
_H8_P3 = "H8 and P3 manuals"
_P2_P3 = "P2 and P3 manuals"
_P3_AMIGO = "P3 and Amigo manuals"
_H8_P3_AMIGO = "H8, P3 and Amigo manuals"
_AMIGO = "Amigo manual"
_P2_H8_AMIGO = "P2, H8 and Amigo manuals"
_SIMULATOR = "client library (simulator commands)"

_ROWS = (
    (Command.SYNC0, _NONE, _COUNT, "handshake; PULSE once connected: refreshes the watchdog", "all", _MANUALS),
    (Command.SYNC1, _NONE, _COUNT, "handshake; OPEN once synchronised: starts the servers", "all", _MANUALS),
    (Command.SYNC2, _NONE, _COUNT, "handshake; CLOSE once connected: stops the servers", "all", _MANUALS),
    (
        Command.POLLING,
        _STRING,
        _COUNT,
        "sonar numbers 1 to 32 in firing order; none disables sonar",
        "P2 1.0, A 1.0, C",
        _MANUALS,
    ),
    (Command.ENABLE, _INT, _COUNT, "1 enable, 0 disable the motors", "P2 1.0, A 1.0", _P2_H8),
    (Command.SETA, _INT, _ACCELERATION, "positive: acceleration; negative: deceleration", "P2 1.0, A 1.0", _P2_H8),
    (Command.SETV, _INT, _SPEED, "maximum translational speed", "P2 1.0, A 1.0", _P2_H8),
    (Command.SETO, _NONE, _COUNT, "reset odometry to zero", "all", _MANUALS),
    (Command.MOVE, _INT, _LENGTH, "translate from here", "P2, A 1.0", _P2_H8),
    (Command.ROTATE, _INT, _ROTATION, "rotate, as RVEL", "A 1.0", _H8),
    (Command.SETRV, _INT, _ROTATION, "maximum rotational speed", "P2 1.0", _P2),
    (Command.VEL, _INT, _SPEED, "translate at a speed", "all", _MANUALS),
    (Command.HEAD, _INT, _ANGLE, "turn to an absolute heading, counter-clockwise", "all", _MANUALS),
    (Command.DHEAD, _INT, _ANGLE, "turn relative to the present heading", "all", _MANUALS),
    (Command.SETRV_DIRECTIONAL, _INT, _ROTATION, "maximum turn rates: positive left, negative right", "C 2.8", _NOTES),
    (Command.SAY, _STRING, _COUNT, "up to 20 pairs of duration (20 ms) and tone", "all", _MANUALS),
    (Command.JOYREQUEST, _INT, _COUNT, "JOYSTICKpac: 0 stop, 1 one, 2 continuous", "C", _P3),
    (Command.CONFIG, _NONE, _COUNT, "request a CONFIGpac", "P2 1.4", _P2),
    (Command.ENCODER, _INT, _COUNT, "ENCODERpac: 0 stop, 1 one, 2 and more continuous", "P2 1.4", _P2),
    (Command.SETRVDIR, _INT, _ROTATION, "as 14, by another number", "library", _LIBRARY),
    (Command.RVEL, _INT, _ROTATION, "rotate at a speed, counter-clockwise", "all", _MANUALS),
    (Command.DCHEAD, _INT, _ANGLE, "turn relative to the last heading setpoint", "P2", _P2),
    (Command.SETRA, _INT, _ANGULAR_ACCELERATION, "positive: acceleration; negative: deceleration", "P2 1.0", _P2),
    (Command.IMUREQUEST, _INT, _COUNT, "IMU packets: 0, 1, 2", "library (Seekur)", _LIBRARY),
    (Command.SONAR, _INT, _COUNT, "bit 0: enable or disable; bits 1-3: array 1 to 4, 0 all", "P2 1.0, A, C", _MANUALS),
    (Command.STOP, _NONE, _COUNT, "stop, the motors stay enabled", "P2, A", _P2_H8),
    (Command.DIGOUT, _BYTES, _COUNT, "high byte: mask of outputs to change; low byte: values", "P2 1.2", _P2),
    (
        Command.SETPBIOPORT,
        _BYTES,
        _COUNT,
        "high byte: number of a power output; low byte: on or off",
        "library",
        _LIBRARY,
    ),
    (
        Command.VEL2,
        _BYTES,
        _COUNT,
        "wheel speeds in the VEL2 unit: high byte left, low right, signed",
        "P2, A, C 1.1",
        _MANUALS,
    ),
    (Command.GRIPPER, _INT, _COUNT, "gripper server command", "P2", _P2),
    (Command.ADSEL, _INT, _COUNT, "analog port that the SIP reports", "C 1.0", _P3),
    (Command.GRIPPERVAL, _INT, _COUNT, "value for the preceding GRIPPER", "P2", _P2),
    (Command.GRIPREQUEST, _INT, _COUNT, "GRIPPERpac: 0, 1, 2 and more", "A, C 1.0", _H8_P3),
    (Command.GYROCALCW, _UINT, _COUNT, "gyro calibration, clockwise", "C 2.0", _P3),
    (Command.GYROCALCCW, _UINT, _COUNT, "gyro calibration, counter-clockwise", "C 2.0", _P3),
    (Command.IOREQUEST, _INT, _COUNT, "IOpac: 0 stop, 1 one, 2 and more continuous", "P2 1.E", _P2),
    (Command.PTUPOS, _BYTES, _COUNT, "high byte: servo port 1 to 4; low byte: pulse width", "PSOS 4.5, P2 1.2", _P2),
    (Command.TTY2, _STRING, _COUNT, "send bytes out of AUX1", "P2 1.0", _P2),
    (Command.GETAUX, _UINT, _COUNT, "return so many bytes from AUX1; 0 flushes", "P2 1.4", _P2),
    (Command.BUMPSTALL, _INT, _COUNT, "stall on contact: 0 none, 1 front, 2 rear, 3 both", "P2 1.5, C", _P2_P3),
    (Command.TCM2, _INT, _COUNT, "compass module mode", "P2 1.6", _P2),
    (Command.DOCK, _INT, _COUNT, "0 off, 1 docking signals, 2 and stop when power is sensed", "P2 1.C", _P2_P3),
    (Command.JOYDRIVE, _INT, _COUNT, "1 allows joystick driving while connected", "P2 1.G", _P2),
    (Command.SONARCYCLE, _UINT, _DURATION, "time from one sonar firing to the next", "A 1.8, C", _H8_P3),
    (Command.MOVINGBLINK, _INT, _COUNT, "PatrolBot lamp", "library", _LIBRARY),
    (Command.HOSTBAUD, _INT, _COUNT, "host rate: 0 9600, 1 19200, 2 38400, 3 57600, 4 115200", "A, C 1.0", _H8_P3),
    (Command.AUX1BAUD, _INT, _COUNT, "AUX1 rate, likewise", "A, C 1.0", _H8_P3),
    (Command.AUX2BAUD, _INT, _COUNT, "AUX2 rate, likewise", "A, C 1.0", _H8_P3),
    (Command.AUX3BAUD, _INT, _COUNT, "AUX3 rate, likewise", "A, C 1.0", _H8_P3),
    (Command.ESTOP, _NONE, _COUNT, "emergency stop, ignores the deceleration limit", "P2 1.8", _P2),
    (Command.ESTALL, _INT, _COUNT, "1: the STOP button stalls and disables the motors", "P2 1.E", _P2),
    (Command.ESTOP_ALIAS, _NONE, _COUNT, "as 55", "simulator", _LIBRARY),
    (Command.GYRO, _INT, _COUNT, "gyro packets: 1 on, 0 off", "A 1.8", _H8),
    (Command.LCDWRITE, _STRING, _COUNT, "text for the LCD accessory", "C (number unverified)", _LIBRARY),
    (Command.TTY4, _STRING, _COUNT, "send bytes out of AUX3", "C 1.0", _P3),
    (Command.GETAUX3, _UINT, _COUNT, "as GETAUX for AUX3", "C 1.0", _P3),
    (Command.BATTERYINFO, _INT, _COUNT, "battery packets: 0, 1, 2", "library", _LIBRARY),
    (Command.LOADWORLD, _STRING, _COUNT, "an older simulator's command", "library", _LIBRARY),
    (Command.STEP, _NONE, _COUNT, "single step, simulator only", "PSOS 3.x, P2 1.0", _P2),
    (Command.CALCOMP, _INT, _COUNT, "compass calibration", "library", _LIBRARY),
    (
        Command.TTY3,
        _STRING,
        _COUNT,
        "send bytes out of AUX2",
        "A 1.1 (assumed: as GETAUX2), C 1.0, AmigOS 1.3",
        _P3_AMIGO,
    ),
    (Command.GETAUX2, _UINT, _COUNT, "as GETAUX for AUX2", "A 1.1, C 1.0, AmigOS 1.3", _H8_P3_AMIGO),
    (Command.CHARGE, _INT, _COUNT, "1 deploy, 0 release the automatic charger", "A 1.7, C 1.0", _H8_P3),
    (Command.RESETSIMTOORIGIN, _NONE, _COUNT, "an older simulator's command", "library", _LIBRARY),
    (Command.ARM_INFO, _NONE, _COUNT, "request an ARMINFOpac", "P2 1.H, A 1.3, C 1.1", _MANUALS),
    (Command.ARM_STATUS, _INT, _COUNT, "ARMpac: 0 stop, 1 one, 2 continuous", "P2 1.H, A 1.3, C 1.1", _MANUALS),
    (Command.ARM_INIT, _NONE, _COUNT, "initialise the arm", "P2 1.H, A 1.3, C 1.1", _MANUALS),
    (Command.ARM_CHECK, _NONE, _COUNT, "look for the arm", "P2 1.H, A 1.3, C 1.1", _MANUALS),
    (Command.ARM_POWER, _INT, _COUNT, "arm power on or off", "P2 1.H, A 1.3, C 1.1", _MANUALS),
    (Command.ARM_HOME, _INT, _COUNT, "home a joint", "P2 1.H, A 1.3, C 1.1", _MANUALS),
    (Command.ARM_PARK, _NONE, _COUNT, "park the arm", "P2 1.H, A 1.3, C 1.1", _MANUALS),
    (Command.ARM_POS, _BYTES, _COUNT, "move a joint", "P2 1.H, A 1.3, C 1.1", _MANUALS),
    (Command.ARM_SPEED, _BYTES, _COUNT, "speed of a joint", "P2 1.H, A 1.3, C 1.1", _MANUALS),
    (Command.ARM_STOP, _INT, _COUNT, "stop a joint", "P2 1.H, A 1.3, C 1.1", _MANUALS),
    (Command.ARM_AUTOPARK, _INT, _COUNT, "s without command before parking, 0 never", "P2 1.H, A 1.3, C 1.1", _MANUALS),
    (Command.ARM_GRIPPARK, _INT, _COUNT, "as ARM_AUTOPARK, for the gripper", "P2 1.H, A 1.3, C 1.1", _MANUALS),
    (Command.ROTKP, _INT, _COUNT, "rotational gain KP, working value", "P2 1.J, A 1.1, C", _MANUALS),
    (Command.ROTKV, _INT, _COUNT, "rotational gain KV, working value", "P2 1.J, A 1.1, C", _MANUALS),
    (Command.ROTKI, _INT, _COUNT, "rotational gain KI, working value", "P2 1.J, A 1.1, C", _MANUALS),
    (Command.TRANSKP, _INT, _COUNT, "translational gain KP, working value", "P2 1.J, A 1.1, C", _MANUALS),
    (Command.TRANSKV, _INT, _COUNT, "translational gain KV, working value", "P2 1.J, A 1.1, C", _MANUALS),
    (Command.TRANSKI, _INT, _COUNT, "translational gain KI, working value", "P2 1.J, A 1.1, C", _MANUALS),
    (Command.REVCOUNT, _INT, _COUNT, "encoder ticks of a turn (AROS), of half a turn (ARCOS)", "A 1.1, C 1.1", _H8_P3),
    (Command.DRIFTFACTOR, _INT, _COUNT, "1/8192 added to the left encoder", "C 1.0", _P3),
    (Command.SOUND, _INT, _COUNT, "play a sound", "AmigOS", _AMIGO),
    (Command.PLAYLIST, _INT, _COUNT, "request the sound list, 0 all", "P2 1.E, A 1.0, AmigOS", _P2_H8_AMIGO),
    (Command.SOUNDTOG, _INT, _COUNT, "0 mute, 1 enable the buzzer", "A 1.0, C", _H8_P3),
    (Command.TICKSMM, _INT, _COUNT, "encoder ticks per mm", "C 1.1", _P3),
    (Command.POWER_PC, _INT, _COUNT, "power output", "library", _LIBRARY),
    (Command.POWER_LRF, _INT, _COUNT, "power output", "library", _LIBRARY),
    (Command.POWER_5V, _INT, _COUNT, "power output", "library", _LIBRARY),
    (Command.POWER_12V, _INT, _COUNT, "power output (24 V on some robots)", "library", _LIBRARY),
    (Command.LATVEL, _INT, _SPEED, "translate sideways", "Seekur", _LIBRARY),
    (
        Command.LATACCEL,
        _INT,
        _ACCELERATION,
        "positive: lateral acceleration; negative: deceleration",
        "Seekur",
        _LIBRARY,
    ),
    (Command.RECENTERWHEELS, _NONE, _COUNT, "steer the wheels straight", "library (Seekur)", _LIBRARY),
    (Command.ACCELINFO, _INT, _COUNT, "accelerometer packets: 0, 1, 2", "MTX", _LIBRARY),
    (Command.TORQUEINFO, _INT, _COUNT, "torque packets: 0, 1, 2", "MTX", _LIBRARY),
    (Command.POWER_AUX_PC, _INT, _COUNT, "power output", "MTX", _LIBRARY),
    (Command.POWER_TOUCHSCREEN, _INT, _COUNT, "power output", "MTX", _LIBRARY),
    (Command.POWER_PTZ, _INT, _COUNT, "power output", "MTX", _LIBRARY),
    (Command.POWER_AUDIO, _INT, _COUNT, "power output", "MTX", _LIBRARY),
    (Command.POWER_LRF2, _INT, _COUNT, "power output", "MTX", _LIBRARY),
    (Command.HEADINGINFO, _INT, _COUNT, "heading packets", "MTX", _LIBRARY),
    (Command.ROTVEL_CLOSEDLOOP_ENABLE, _INT, _COUNT, "closed loop of the rotational speed", "MTX", _LIBRARY),
    (Command.SRECORD, _DATA, _COUNT, "controller maintenance", "library (MTX)", _LIBRARY),
    (Command.MARCDEBUG, _DATA, _COUNT, "debug text", "library (MTX)", _LIBRARY),
    (Command.WHEEL_LIGHT, _DATA, _COUNT, "wheel lights", "library (MTX)", _LIBRARY),
    (Command.ABSOLUTE_MAXES, _DATA, _COUNT, "absolute limits", "library (MTX)", _LIBRARY),
    (Command.SAFETY_STATE_INFO, _DATA, _COUNT, "state of the safety system", "library (MTX)", _LIBRARY),
    (Command.SAFETY_SET_STATE, _DATA, _COUNT, "set the safety system", "library (MTX)", _LIBRARY),
    (Command.SAFETY_DISABLE_POWER_OFF_TIMER, _DATA, _COUNT, "safety system", "library (MTX)", _LIBRARY),
    (Command.SAFETY_ZONE_ACTIVE, _DATA, _COUNT, "safety system", "library (MTX)", _LIBRARY),
    (Command.WHEELINFO_REQUEST, _DATA, _COUNT, "wheel packets", "library (MTX)", _LIBRARY),
    (Command.MARC_CONFIG_SET, _DATA, _COUNT, "controller configuration", "library (MTX)", _LIBRARY),
    (Command.MARC_CONFIG_GET, _DATA, _COUNT, "controller configuration", "library (MTX)", _LIBRARY),
    (Command.SIM_SET_POSE, _DATA, _COUNT, "move the true pose: i32 x mm, y mm, heading deg", "simulator", _SIMULATOR),
    (Command.SIM_RESET, _NONE, _COUNT, "reset pose and odometry", "simulator", _SIMULATOR),
    (Command.SIM_MODEL_CONFIG, _DATA, _COUNT, "model configuration", "simulator", _SIMULATOR),
    (
        Command.SIM_LRF_ENABLE,
        _INT,
        _COUNT,
        "laser in the robot's line: 0 off, 1 on, 2 extended",
        "simulator",
        _SIMULATOR,
    ),
    (Command.SIM_LRF_SET_FOV_START, _INT, _ANGLE, "first bearing", "simulator", _SIMULATOR),
    (Command.SIM_LRF_SET_FOV_END, _INT, _ANGLE, "last bearing", "simulator", _SIMULATOR),
    (Command.SIM_LRF_SET_RES, _INT, _ANGLE, "between two bearings", "simulator", _SIMULATOR),
    (Command.SIM_CTRL, _DATA, _COUNT, "i16 operation and its data", "simulator", _SIMULATOR),
    (Command.SIM_STAT, _INT, _COUNT, "SIMSTAT packets: 0 stop, 1 one, 2 continuous", "simulator", _SIMULATOR),
    (Command.SIM_MESSAGE, _STRING, _COUNT, "text", "simulator", _SIMULATOR),
    (Command.SIM_EXIT, _INT, _COUNT, "leave with an exit code", "simulator", _SIMULATOR),
    (
        Command.BATTEST,
        _INT,
        _VOLTAGE,
        "ARCOS: pretend a voltage, 0 the real one; AROS: SHUTDOWN",
        "A 1.6, C 1.0",
        _H8_P3,
    ),
    (Command.DIGTEMPTEST, _INT, _COUNT, "pretend a temperature warning", "simulator", _LIBRARY),
    (Command.SPOOFANALOGTEMP, _INT, _COUNT, "pretend a temperature", "simulator", _LIBRARY),
    (Command.RESET, _NONE, _COUNT, "reset the controller as power-on does", "C 1.0", _P3),
    (Command.MAINTENANCE, _NONE, _COUNT, "enter maintenance mode", "C 1.0", _P3),
)

COMMANDS: Mapping[int, CommandSpec] = {
    command.value: CommandSpec(command.value, command.name, argument, quantity, meaning, Since.read(since), source)
    for command, argument, quantity, meaning, since, source in _ROWS
}
"""The table by command number."""


def known_commands(family: Family, version: str) -> frozenset[int]:
    """Numbers of the commands that firmware of a family and version, such as "1.M", knows."""
    return frozenset(number for number, spec in COMMANDS.items() if spec.since.known_to(family, version))

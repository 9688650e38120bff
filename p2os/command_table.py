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


class Command(IntEnum):
    """The commands by name; PULSE, OPEN and CLOSE share their rows with the handshake.

    argument: what follows the number. quantity: what it measures. meaning, source: for people. since: which firmware
    knows the command.
    """

    argument: Argument
    quantity: Quantity
    meaning: str
    since: Since
    source: str

    def __new__(
        cls, number: int, argument: Argument, quantity: Quantity, meaning: str, since: str, source: str
    ) -> "Command":
        """Make a member of a row."""
        command = int.__new__(cls, number)
        command._value_ = number
        command.argument = argument
        command.quantity = quantity
        command.meaning = meaning
        command.since = Since.read(since)
        command.source = source
        return command

    SYNC0 = 0, _NONE, _COUNT, "handshake; PULSE once connected: refreshes the watchdog", "all", _MANUALS
    PULSE = SYNC0
    SYNC1 = 1, _NONE, _COUNT, "handshake; OPEN once synchronised: starts the servers", "all", _MANUALS
    OPEN = SYNC1
    SYNC2 = 2, _NONE, _COUNT, "handshake; CLOSE once connected: stops the servers", "all", _MANUALS
    CLOSE = SYNC2
    POLLING = (
        3,
        _STRING,
        _COUNT,
        "sonar numbers 1 to 32 in firing order; none disables sonar",
        "P2 1.0, A 1.0, C",
        _MANUALS,
    )
    ENABLE = 4, _INT, _COUNT, "1 enable, 0 disable the motors", "P2 1.0, A 1.0", _P2_H8
    SETA = 5, _INT, _ACCELERATION, "positive: acceleration; negative: deceleration", "P2 1.0, A 1.0", _P2_H8
    SETV = 6, _INT, _SPEED, "maximum translational speed", "P2 1.0, A 1.0", _P2_H8
    SETO = 7, _NONE, _COUNT, "reset odometry to zero", "all", _MANUALS
    MOVE = 8, _INT, _LENGTH, "translate from here", "P2, A 1.0", _P2_H8
    ROTATE = 9, _INT, _ROTATION, "rotate, as RVEL", "A 1.0", _H8
    SETRV = 10, _INT, _ROTATION, "maximum rotational speed", "P2 1.0", _P2
    VEL = 11, _INT, _SPEED, "translate at a speed", "all", _MANUALS
    HEAD = 12, _INT, _ANGLE, "turn to an absolute heading, counter-clockwise", "all", _MANUALS
    DHEAD = 13, _INT, _ANGLE, "turn relative to the present heading", "all", _MANUALS
    SETRV_DIRECTIONAL = 14, _INT, _ROTATION, "maximum turn rates: positive left, negative right", "C 2.8", _NOTES
    SAY = 15, _STRING, _COUNT, "up to 20 pairs of duration (20 ms) and tone", "all", _MANUALS
    JOYREQUEST = 17, _INT, _COUNT, "JOYSTICKpac: 0 stop, 1 one, 2 continuous", "C", _P3
    CONFIG = 18, _NONE, _COUNT, "request a CONFIGpac", "P2 1.4", _P2
    ENCODER = 19, _INT, _COUNT, "ENCODERpac: 0 stop, 1 one, 2 and more continuous", "P2 1.4", _P2
    SETRVDIR = 20, _INT, _ROTATION, "as 14, by another number", "library", _LIBRARY
    RVEL = 21, _INT, _ROTATION, "rotate at a speed, counter-clockwise", "all", _MANUALS
    DCHEAD = 22, _INT, _ANGLE, "turn relative to the last heading setpoint", "P2", _P2
    SETRA = 23, _INT, _ANGULAR_ACCELERATION, "positive: acceleration; negative: deceleration", "P2 1.0", _P2
    IMUREQUEST = 26, _INT, _COUNT, "IMU packets: 0, 1, 2", "library (Seekur)", _LIBRARY
    SONAR = 28, _INT, _COUNT, "bit 0: enable or disable; bits 1-3: array 1 to 4, 0 all", "P2 1.0, A, C", _MANUALS
    STOP = 29, _NONE, _COUNT, "stop, the motors stay enabled", "P2, A", _P2_H8
    DIGOUT = 30, _BYTES, _COUNT, "high byte: mask of outputs to change; low byte: values", "P2 1.2", _P2
    SETPBIOPORT = 31, _BYTES, _COUNT, "high byte: number of a power output; low byte: on or off", "library", _LIBRARY
    VEL2 = (
        32,
        _BYTES,
        _COUNT,
        "wheel speeds in the VEL2 unit: high byte left, low right, signed",
        "P2, A, C 1.1",
        _MANUALS,
    )
    GRIPPER = 33, _INT, _COUNT, "gripper server command", "P2", _P2
    ADSEL = 35, _INT, _COUNT, "analog port that the SIP reports", "C 1.0", _P3
    GRIPPERVAL = 36, _INT, _COUNT, "value for the preceding GRIPPER", "P2", _P2
    GRIPREQUEST = 37, _INT, _COUNT, "GRIPPERpac: 0, 1, 2 and more", "A, C 1.0", _H8_P3
    GYROCALCW = 38, _UINT, _COUNT, "gyro calibration, clockwise", "C 2.0", _P3
    GYROCALCCW = 39, _UINT, _COUNT, "gyro calibration, counter-clockwise", "C 2.0", _P3
    IOREQUEST = 40, _INT, _COUNT, "IOpac: 0 stop, 1 one, 2 and more continuous", "P2 1.E", _P2
    PTUPOS = 41, _BYTES, _COUNT, "high byte: servo port 1 to 4; low byte: pulse width", "PSOS 4.5, P2 1.2", _P2
    TTY2 = 42, _STRING, _COUNT, "send bytes out of AUX1", "P2 1.0", _P2
    GETAUX = 43, _UINT, _COUNT, "return so many bytes from AUX1; 0 flushes", "P2 1.4", _P2
    BUMPSTALL = 44, _INT, _COUNT, "stall on contact: 0 none, 1 front, 2 rear, 3 both", "P2 1.5, C", _P2_P3
    TCM2 = 45, _INT, _COUNT, "compass module mode", "P2 1.6", _P2
    DOCK = 46, _INT, _COUNT, "0 off, 1 docking signals, 2 and stop when power is sensed", "P2 1.C", _P2_P3
    JOYDRIVE = 47, _INT, _COUNT, "1 allows joystick driving while connected", "P2 1.G", _P2
    SONARCYCLE = 48, _UINT, _DURATION, "time from one sonar firing to the next", "A 1.8, C", _H8_P3
    MOVINGBLINK = 49, _INT, _COUNT, "PatrolBot lamp", "library", _LIBRARY
    HOSTBAUD = 50, _INT, _COUNT, "host rate: 0 9600, 1 19200, 2 38400, 3 57600, 4 115200", "A, C 1.0", _H8_P3
    AUX1BAUD = 51, _INT, _COUNT, "AUX1 rate, likewise", "A, C 1.0", _H8_P3
    AUX2BAUD = 52, _INT, _COUNT, "AUX2 rate, likewise", "A, C 1.0", _H8_P3
    AUX3BAUD = 53, _INT, _COUNT, "AUX3 rate, likewise", "A, C 1.0", _H8_P3
    ESTOP = 55, _NONE, _COUNT, "emergency stop, ignores the deceleration limit", "P2 1.8", _P2
    ESTALL = 56, _INT, _COUNT, "1: the STOP button stalls and disables the motors", "P2 1.E", _P2
    ESTOP_ALIAS = 57, _NONE, _COUNT, "as 55", "simulator", _LIBRARY
    GYRO = 58, _INT, _COUNT, "gyro packets: 1 on, 0 off", "A 1.8", _H8
    LCDWRITE = 59, _STRING, _COUNT, "text for the LCD accessory", "C (number unverified)", _LIBRARY
    TTY4 = 60, _STRING, _COUNT, "send bytes out of AUX3", "C 1.0", _P3
    GETAUX3 = 61, _UINT, _COUNT, "as GETAUX for AUX3", "C 1.0", _P3
    BATTERYINFO = 62, _INT, _COUNT, "battery packets: 0, 1, 2", "library", _LIBRARY
    LOADWORLD = 63, _STRING, _COUNT, "an older simulator's command", "library", _LIBRARY
    STEP = 64, _NONE, _COUNT, "single step, simulator only", "PSOS 3.x, P2 1.0", _P2
    CALCOMP = 65, _INT, _COUNT, "compass calibration", "library", _LIBRARY
    TTY3 = 66, _STRING, _COUNT, "send bytes out of AUX2", "A 1.1 (assumed: as GETAUX2), C 1.0, AmigOS 1.3", _P3_AMIGO
    GETAUX2 = 67, _UINT, _COUNT, "as GETAUX for AUX2", "A 1.1, C 1.0, AmigOS 1.3", _H8_P3_AMIGO
    CHARGE = 68, _INT, _COUNT, "1 deploy, 0 release the automatic charger", "A 1.7, C 1.0", _H8_P3
    RESETSIMTOORIGIN = 69, _NONE, _COUNT, "an older simulator's command", "library", _LIBRARY
    ARM_INFO = 70, _NONE, _COUNT, "request an ARMINFOpac", "P2 1.H, A 1.3, C 1.1", _MANUALS
    ARM_STATUS = 71, _INT, _COUNT, "ARMpac: 0 stop, 1 one, 2 continuous", "P2 1.H, A 1.3, C 1.1", _MANUALS
    ARM_INIT = 72, _NONE, _COUNT, "initialise the arm", "P2 1.H, A 1.3, C 1.1", _MANUALS
    ARM_CHECK = 73, _NONE, _COUNT, "look for the arm", "P2 1.H, A 1.3, C 1.1", _MANUALS
    ARM_POWER = 74, _INT, _COUNT, "arm power on or off", "P2 1.H, A 1.3, C 1.1", _MANUALS
    ARM_HOME = 75, _INT, _COUNT, "home a joint", "P2 1.H, A 1.3, C 1.1", _MANUALS
    ARM_PARK = 76, _NONE, _COUNT, "park the arm", "P2 1.H, A 1.3, C 1.1", _MANUALS
    ARM_POS = 77, _BYTES, _COUNT, "move a joint", "P2 1.H, A 1.3, C 1.1", _MANUALS
    ARM_SPEED = 78, _BYTES, _COUNT, "speed of a joint", "P2 1.H, A 1.3, C 1.1", _MANUALS
    ARM_STOP = 79, _INT, _COUNT, "stop a joint", "P2 1.H, A 1.3, C 1.1", _MANUALS
    ARM_AUTOPARK = 80, _INT, _COUNT, "s without command before parking, 0 never", "P2 1.H, A 1.3, C 1.1", _MANUALS
    ARM_GRIPPARK = 81, _INT, _COUNT, "as ARM_AUTOPARK, for the gripper", "P2 1.H, A 1.3, C 1.1", _MANUALS
    ROTKP = 82, _INT, _COUNT, "rotational gain KP, working value", "P2 1.J, A 1.1, C", _MANUALS
    ROTKV = 83, _INT, _COUNT, "rotational gain KV, working value", "P2 1.J, A 1.1, C", _MANUALS
    ROTKI = 84, _INT, _COUNT, "rotational gain KI, working value", "P2 1.J, A 1.1, C", _MANUALS
    TRANSKP = 85, _INT, _COUNT, "translational gain KP, working value", "P2 1.J, A 1.1, C", _MANUALS
    TRANSKV = 86, _INT, _COUNT, "translational gain KV, working value", "P2 1.J, A 1.1, C", _MANUALS
    TRANSKI = 87, _INT, _COUNT, "translational gain KI, working value", "P2 1.J, A 1.1, C", _MANUALS
    REVCOUNT = 88, _INT, _COUNT, "encoder ticks of a turn (AROS), of half a turn (ARCOS)", "A 1.1, C 1.1", _H8_P3
    DRIFTFACTOR = 89, _INT, _COUNT, "1/8192 added to the left encoder", "C 1.0", _P3
    SOUND = 90, _INT, _COUNT, "play a sound", "AmigOS", _AMIGO
    PLAYLIST = 91, _INT, _COUNT, "request the sound list, 0 all", "P2 1.E, A 1.0, AmigOS", _P2_H8_AMIGO
    SOUNDTOG = 92, _INT, _COUNT, "0 mute, 1 enable the buzzer", "A 1.0, C", _H8_P3
    TICKSMM = 93, _INT, _COUNT, "encoder ticks per mm", "C 1.1", _P3
    POWER_PC = 95, _INT, _COUNT, "power output", "library", _LIBRARY
    POWER_LRF = 96, _INT, _COUNT, "power output", "library", _LIBRARY
    POWER_5V = 97, _INT, _COUNT, "power output", "library", _LIBRARY
    POWER_12V = 98, _INT, _COUNT, "power output (24 V on some robots)", "library", _LIBRARY
    LATVEL = 110, _INT, _SPEED, "translate sideways", "Seekur", _LIBRARY
    LATACCEL = 113, _INT, _ACCELERATION, "positive: lateral acceleration; negative: deceleration", "Seekur", _LIBRARY
    RECENTERWHEELS = 120, _NONE, _COUNT, "steer the wheels straight", "library (Seekur)", _LIBRARY
    ACCELINFO = 123, _INT, _COUNT, "accelerometer packets: 0, 1, 2", "MTX", _LIBRARY
    TORQUEINFO = 124, _INT, _COUNT, "torque packets: 0, 1, 2", "MTX", _LIBRARY
    POWER_AUX_PC = 125, _INT, _COUNT, "power output", "MTX", _LIBRARY
    POWER_TOUCHSCREEN = 126, _INT, _COUNT, "power output", "MTX", _LIBRARY
    POWER_PTZ = 127, _INT, _COUNT, "power output", "MTX", _LIBRARY
    POWER_AUDIO = 128, _INT, _COUNT, "power output", "MTX", _LIBRARY
    POWER_LRF2 = 129, _INT, _COUNT, "power output", "MTX", _LIBRARY
    HEADINGINFO = 149, _INT, _COUNT, "heading packets", "MTX", _LIBRARY
    ROTVEL_CLOSEDLOOP_ENABLE = 150, _INT, _COUNT, "closed loop of the rotational speed", "MTX", _LIBRARY
    SRECORD = 210, _DATA, _COUNT, "controller maintenance", "library (MTX)", _LIBRARY
    MARCDEBUG = 211, _DATA, _COUNT, "debug text", "library (MTX)", _LIBRARY
    WHEEL_LIGHT = 212, _DATA, _COUNT, "wheel lights", "library (MTX)", _LIBRARY
    ABSOLUTE_MAXES = 213, _DATA, _COUNT, "absolute limits", "library (MTX)", _LIBRARY
    SAFETY_STATE_INFO = 214, _DATA, _COUNT, "state of the safety system", "library (MTX)", _LIBRARY
    SAFETY_SET_STATE = 215, _DATA, _COUNT, "set the safety system", "library (MTX)", _LIBRARY
    SAFETY_DISABLE_POWER_OFF_TIMER = 216, _DATA, _COUNT, "safety system", "library (MTX)", _LIBRARY
    SAFETY_ZONE_ACTIVE = 217, _DATA, _COUNT, "safety system", "library (MTX)", _LIBRARY
    WHEELINFO_REQUEST = 218, _DATA, _COUNT, "wheel packets", "library (MTX)", _LIBRARY
    MARC_CONFIG_SET = 219, _DATA, _COUNT, "controller configuration", "library (MTX)", _LIBRARY
    MARC_CONFIG_GET = 220, _DATA, _COUNT, "controller configuration", "library (MTX)", _LIBRARY
    SIM_SET_POSE = 224, _DATA, _COUNT, "move the true pose: i32 x mm, y mm, heading deg", "simulator", _SIMULATOR
    SIM_RESET = 225, _NONE, _COUNT, "reset pose and odometry", "simulator", _SIMULATOR
    SIM_MODEL_CONFIG = 226, _DATA, _COUNT, "model configuration", "simulator", _SIMULATOR
    SIM_LRF_ENABLE = 230, _INT, _COUNT, "laser in the robot's line: 0 off, 1 on, 2 extended", "simulator", _SIMULATOR
    SIM_LRF_SET_FOV_START = 231, _INT, _ANGLE, "first bearing", "simulator", _SIMULATOR
    SIM_LRF_SET_FOV_END = 232, _INT, _ANGLE, "last bearing", "simulator", _SIMULATOR
    SIM_LRF_SET_RES = 233, _INT, _ANGLE, "between two bearings", "simulator", _SIMULATOR
    SIM_CTRL = 236, _DATA, _COUNT, "i16 operation and its data", "simulator", _SIMULATOR
    SIM_STAT = 237, _INT, _COUNT, "SIMSTAT packets: 0 stop, 1 one, 2 continuous", "simulator", _SIMULATOR
    SIM_MESSAGE = 238, _STRING, _COUNT, "text", "simulator", _SIMULATOR
    SIM_EXIT = 239, _INT, _COUNT, "leave with an exit code", "simulator", _SIMULATOR
    BATTEST = 250, _INT, _VOLTAGE, "ARCOS: pretend a voltage, 0 the real one; AROS: SHUTDOWN", "A 1.6, C 1.0", _H8_P3
    SHUTDOWN = BATTEST
    DIGTEMPTEST = 251, _INT, _COUNT, "pretend a temperature warning", "simulator", _LIBRARY
    SPOOFANALOGTEMP = 252, _INT, _COUNT, "pretend a temperature", "simulator", _LIBRARY
    RESET = 253, _NONE, _COUNT, "reset the controller as power-on does", "C 1.0", _P3
    MAINTENANCE = 255, _NONE, _COUNT, "enter maintenance mode", "C 1.0", _P3


COMMANDS: Mapping[int, Command] = {command.value: command for command in Command}
"""The commands by number."""


def known_commands(family: Family, version: str) -> frozenset[int]:
    """Return the numbers of the commands that firmware of a family and version, such as "1.M", knows."""
    return frozenset(number for number, command in COMMANDS.items() if command.since.known_to(family, version))

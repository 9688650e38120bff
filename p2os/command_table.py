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
    since: str
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


_ROWS = (
    (
        Command.SYNC0,
        Argument.NONE,
        Quantity.COUNT,
        "handshake; PULSE once connected: refreshes the watchdog",
        "all",
        "P2, H8 and P3 manuals",
    ),
    (
        Command.SYNC1,
        Argument.NONE,
        Quantity.COUNT,
        "handshake; OPEN once synchronised: starts the servers",
        "all",
        "P2, H8 and P3 manuals",
    ),
    (
        Command.SYNC2,
        Argument.NONE,
        Quantity.COUNT,
        "handshake; CLOSE once connected: stops the servers",
        "all",
        "P2, H8 and P3 manuals",
    ),
    (
        Command.POLLING,
        Argument.STRING,
        Quantity.COUNT,
        "sonar firing sequence, numbers 1 to 32; empty disables all sonar",
        "P2 1.0, A 1.0, C",
        "P2, H8 and P3 manuals",
    ),
    (
        Command.ENABLE,
        Argument.INT,
        Quantity.COUNT,
        "1 enable, 0 disable the motors",
        "P2 1.0, A 1.0",
        "P2 and H8 manuals",
    ),
    (
        Command.SETA,
        Argument.INT,
        Quantity.ACCELERATION,
        "positive: translational acceleration; negative: deceleration",
        "P2 1.0, A 1.0",
        "P2 and H8 manuals",
    ),
    (Command.SETV, Argument.INT, Quantity.SPEED, "maximum translational speed", "P2 1.0, A 1.0", "P2 and H8 manuals"),
    (Command.SETO, Argument.NONE, Quantity.COUNT, "reset odometry to zero", "all", "P2, H8 and P3 manuals"),
    (Command.MOVE, Argument.INT, Quantity.LENGTH, "translate from here", "P2, A 1.0", "P2 and H8 manuals"),
    (Command.ROTATE, Argument.INT, Quantity.ROTATION, "rotate, as RVEL", "A 1.0", "H8 manual"),
    (Command.SETRV, Argument.INT, Quantity.ROTATION, "maximum rotational speed", "P2 1.0", "P2 manual"),
    (Command.VEL, Argument.INT, Quantity.SPEED, "translate at a speed", "all", "P2, H8 and P3 manuals"),
    (
        Command.HEAD,
        Argument.INT,
        Quantity.ANGLE,
        "turn to an absolute heading, counter-clockwise",
        "all",
        "P2, H8 and P3 manuals",
    ),
    (
        Command.DHEAD,
        Argument.INT,
        Quantity.ANGLE,
        "turn relative to the present heading",
        "all",
        "P2, H8 and P3 manuals",
    ),
    (
        Command.SETRV_DIRECTIONAL,
        Argument.INT,
        Quantity.ROTATION,
        "positive: counter-clockwise maximum; negative: clockwise maximum",
        "C 2.x",
        "ARCOS 2.8 release notes",
    ),
    (
        Command.SAY,
        Argument.STRING,
        Quantity.COUNT,
        "up to 20 pairs of duration (20 ms) and tone",
        "all",
        "P2, H8 and P3 manuals",
    ),
    (Command.JOYREQUEST, Argument.INT, Quantity.COUNT, "JOYSTICKpac: 0 stop, 1 one, 2 continuous", "C", "P3 manual"),
    (Command.CONFIG, Argument.NONE, Quantity.COUNT, "request a CONFIGpac", "P2 1.4", "P2 manual"),
    (
        Command.ENCODER,
        Argument.INT,
        Quantity.COUNT,
        "ENCODERpac: 0 stop, 1 one, 2 and more continuous",
        "P2 1.4",
        "P2 manual",
    ),
    (Command.SETRVDIR, Argument.INT, Quantity.ROTATION, "as 14, by another number", "library", "client library"),
    (
        Command.RVEL,
        Argument.INT,
        Quantity.ROTATION,
        "rotate at a speed, counter-clockwise",
        "all",
        "P2, H8 and P3 manuals",
    ),
    (Command.DCHEAD, Argument.INT, Quantity.ANGLE, "turn relative to the last heading setpoint", "P2", "P2 manual"),
    (
        Command.SETRA,
        Argument.INT,
        Quantity.ANGULAR_ACCELERATION,
        "positive: rotational acceleration; negative: deceleration",
        "P2 1.0",
        "P2 manual",
    ),
    (Command.IMUREQUEST, Argument.INT, Quantity.COUNT, "IMU packets: 0, 1, 2", "library (Seekur)", "client library"),
    (
        Command.SONAR,
        Argument.INT,
        Quantity.COUNT,
        "bit 0: enable or disable; bits 1-3: array 1 to 4, 0 all",
        "P2 1.0, A, C",
        "P2, H8 and P3 manuals",
    ),
    (Command.STOP, Argument.NONE, Quantity.COUNT, "stop, the motors stay enabled", "P2, A", "P2 and H8 manuals"),
    (
        Command.DIGOUT,
        Argument.TWO_BYTES,
        Quantity.COUNT,
        "high byte: mask of outputs to change; low byte: values",
        "P2 1.2",
        "P2 manual",
    ),
    (
        Command.SETPBIOPORT,
        Argument.TWO_BYTES,
        Quantity.COUNT,
        "likewise for the power outputs of PatrolBot and PowerBot",
        "library",
        "client library",
    ),
    (
        Command.VEL2,
        Argument.TWO_BYTES,
        Quantity.COUNT,
        "high byte: left wheel, low byte: right wheel, signed, in the model's VEL2 unit",
        "P2, A, C 1.1",
        "P2, H8 and P3 manuals",
    ),
    (Command.GRIPPER, Argument.INT, Quantity.COUNT, "gripper server command", "P2", "P2 manual"),
    (Command.ADSEL, Argument.INT, Quantity.COUNT, "analog port that the SIP reports", "C 1.0", "P3 manual"),
    (Command.GRIPPERVAL, Argument.INT, Quantity.COUNT, "value for the preceding GRIPPER", "P2", "P2 manual"),
    (
        Command.GRIPREQUEST,
        Argument.INT,
        Quantity.COUNT,
        "GRIPPERpac: 0, 1, 2 and more",
        "A, C 1.0",
        "H8 and P3 manuals",
    ),
    (Command.GYROCALCW, Argument.UINT, Quantity.COUNT, "gyro calibration, clockwise", "C 2.0", "P3 manual"),
    (Command.GYROCALCCW, Argument.UINT, Quantity.COUNT, "gyro calibration, counter-clockwise", "C 2.0", "P3 manual"),
    (
        Command.IOREQUEST,
        Argument.INT,
        Quantity.COUNT,
        "IOpac: 0 stop, 1 one, 2 and more continuous",
        "P2 1.E",
        "P2 manual",
    ),
    (
        Command.PTUPOS,
        Argument.TWO_BYTES,
        Quantity.COUNT,
        "high byte: servo port 1 to 4; low byte: pulse width",
        "PSOS 4.5, P2 1.2",
        "P2 manual",
    ),
    (Command.TTY2, Argument.STRING, Quantity.COUNT, "send bytes out of AUX1", "P2 1.0", "P2 manual"),
    (Command.GETAUX, Argument.UINT, Quantity.COUNT, "return so many bytes from AUX1; 0 flushes", "P2 1.4", "P2 manual"),
    (
        Command.BUMPSTALL,
        Argument.INT,
        Quantity.COUNT,
        "stall on contact: 0 none, 1 front, 2 rear, 3 both",
        "P2 1.5, C",
        "P2 and P3 manuals",
    ),
    (Command.TCM2, Argument.INT, Quantity.COUNT, "compass module mode", "P2 1.6", "P2 manual"),
    (
        Command.DOCK,
        Argument.INT,
        Quantity.COUNT,
        "0 off, 1 docking signals, 2 and stop when power is sensed",
        "P2 1.C",
        "P2 and P3 manuals",
    ),
    (
        Command.JOYDRIVE,
        Argument.INT,
        Quantity.COUNT,
        "1 allows joystick driving while connected",
        "P2 1.G",
        "P2 manual",
    ),
    (
        Command.SONARCYCLE,
        Argument.UINT,
        Quantity.DURATION,
        "time from one sonar firing to the next",
        "A 1.8, C",
        "H8 and P3 manuals",
    ),
    (Command.MOVINGBLINK, Argument.INT, Quantity.COUNT, "PatrolBot lamp", "library", "client library"),
    (
        Command.HOSTBAUD,
        Argument.INT,
        Quantity.COUNT,
        "host rate by code: 0 9600, 1 19200, 2 38400, 3 57600, 4 115200",
        "A, C 1.0",
        "H8 and P3 manuals",
    ),
    (Command.AUX1BAUD, Argument.INT, Quantity.COUNT, "AUX1 rate, likewise", "A, C 1.0", "H8 and P3 manuals"),
    (Command.AUX2BAUD, Argument.INT, Quantity.COUNT, "AUX2 rate, likewise", "A, C 1.0", "H8 and P3 manuals"),
    (Command.AUX3BAUD, Argument.INT, Quantity.COUNT, "AUX3 rate, likewise", "A, C 1.0", "H8 and P3 manuals"),
    (
        Command.ESTOP,
        Argument.NONE,
        Quantity.COUNT,
        "emergency stop, ignores the deceleration limit",
        "P2 1.8",
        "P2 manual",
    ),
    (
        Command.ESTALL,
        Argument.INT,
        Quantity.COUNT,
        "1: the STOP button stalls and disables the motors",
        "P2 1.E",
        "P2 manual",
    ),
    (Command.ESTOP_ALIAS, Argument.NONE, Quantity.COUNT, "as 55", "simulator", "client library"),
    (Command.GYRO, Argument.INT, Quantity.COUNT, "gyro packets: 1 on, 0 off", "A 1.8", "H8 manual"),
    (
        Command.LCDWRITE,
        Argument.STRING,
        Quantity.COUNT,
        "text for the LCD accessory",
        "C (number unverified)",
        "client library",
    ),
    (Command.TTY4, Argument.STRING, Quantity.COUNT, "send bytes out of AUX3", "C 1.0", "P3 manual"),
    (Command.GETAUX3, Argument.UINT, Quantity.COUNT, "as GETAUX for AUX3", "C 1.0", "P3 manual"),
    (Command.BATTERYINFO, Argument.INT, Quantity.COUNT, "battery packets: 0, 1, 2", "library", "client library"),
    (Command.LOADWORLD, Argument.STRING, Quantity.COUNT, "an older simulator's command", "library", "client library"),
    (Command.STEP, Argument.NONE, Quantity.COUNT, "single step, simulator only", "PSOS 3.x, P2 1.0", "P2 manual"),
    (Command.CALCOMP, Argument.INT, Quantity.COUNT, "compass calibration", "library", "client library"),
    (
        Command.TTY3,
        Argument.STRING,
        Quantity.COUNT,
        "send bytes out of AUX2",
        "C 1.0, AmigOS 1.3",
        "P3 and Amigo manuals",
    ),
    (
        Command.GETAUX2,
        Argument.UINT,
        Quantity.COUNT,
        "as GETAUX for AUX2",
        "A 1.1, C 1.0, AmigOS 1.3",
        "H8, P3 and Amigo manuals",
    ),
    (
        Command.CHARGE,
        Argument.INT,
        Quantity.COUNT,
        "1 deploy, 0 release the automatic charger",
        "A 1.7, C 1.0",
        "H8 and P3 manuals",
    ),
    (
        Command.RESETSIMTOORIGIN,
        Argument.NONE,
        Quantity.COUNT,
        "an older simulator's command",
        "library",
        "client library",
    ),
    (
        Command.ARM_INFO,
        Argument.NONE,
        Quantity.COUNT,
        "request an ARMINFOpac",
        "P2 1.H, A 1.3, C 1.1",
        "P2, H8 and P3 manuals",
    ),
    (
        Command.ARM_STATUS,
        Argument.INT,
        Quantity.COUNT,
        "ARMpac: 0 stop, 1 one, 2 continuous",
        "P2 1.H, A 1.3, C 1.1",
        "P2, H8 and P3 manuals",
    ),
    (
        Command.ARM_INIT,
        Argument.NONE,
        Quantity.COUNT,
        "initialise the arm",
        "P2 1.H, A 1.3, C 1.1",
        "P2, H8 and P3 manuals",
    ),
    (
        Command.ARM_CHECK,
        Argument.NONE,
        Quantity.COUNT,
        "look for the arm",
        "P2 1.H, A 1.3, C 1.1",
        "P2, H8 and P3 manuals",
    ),
    (
        Command.ARM_POWER,
        Argument.INT,
        Quantity.COUNT,
        "arm power on or off",
        "P2 1.H, A 1.3, C 1.1",
        "P2, H8 and P3 manuals",
    ),
    (Command.ARM_HOME, Argument.INT, Quantity.COUNT, "home a joint", "P2 1.H, A 1.3, C 1.1", "P2, H8 and P3 manuals"),
    (Command.ARM_PARK, Argument.NONE, Quantity.COUNT, "park the arm", "P2 1.H, A 1.3, C 1.1", "P2, H8 and P3 manuals"),
    (
        Command.ARM_POS,
        Argument.TWO_BYTES,
        Quantity.COUNT,
        "move a joint",
        "P2 1.H, A 1.3, C 1.1",
        "P2, H8 and P3 manuals",
    ),
    (
        Command.ARM_SPEED,
        Argument.TWO_BYTES,
        Quantity.COUNT,
        "speed of a joint",
        "P2 1.H, A 1.3, C 1.1",
        "P2, H8 and P3 manuals",
    ),
    (Command.ARM_STOP, Argument.INT, Quantity.COUNT, "stop a joint", "P2 1.H, A 1.3, C 1.1", "P2, H8 and P3 manuals"),
    (
        Command.ARM_AUTOPARK,
        Argument.INT,
        Quantity.COUNT,
        "time without command before parking",
        "P2 1.H, A 1.3, C 1.1",
        "P2, H8 and P3 manuals",
    ),
    (
        Command.ARM_GRIPPARK,
        Argument.INT,
        Quantity.COUNT,
        "gripper position when parked",
        "P2 1.H, A 1.3, C 1.1",
        "P2, H8 and P3 manuals",
    ),
    (
        Command.ROTKP,
        Argument.INT,
        Quantity.COUNT,
        "rotational gain KP, working value",
        "P2 1.J, A 1.1, C",
        "P2, H8 and P3 manuals",
    ),
    (
        Command.ROTKV,
        Argument.INT,
        Quantity.COUNT,
        "rotational gain KV, working value",
        "P2 1.J, A 1.1, C",
        "P2, H8 and P3 manuals",
    ),
    (
        Command.ROTKI,
        Argument.INT,
        Quantity.COUNT,
        "rotational gain KI, working value",
        "P2 1.J, A 1.1, C",
        "P2, H8 and P3 manuals",
    ),
    (
        Command.TRANSKP,
        Argument.INT,
        Quantity.COUNT,
        "translational gain KP, working value",
        "P2 1.J, A 1.1, C",
        "P2, H8 and P3 manuals",
    ),
    (
        Command.TRANSKV,
        Argument.INT,
        Quantity.COUNT,
        "translational gain KV, working value",
        "P2 1.J, A 1.1, C",
        "P2, H8 and P3 manuals",
    ),
    (
        Command.TRANSKI,
        Argument.INT,
        Quantity.COUNT,
        "translational gain KI, working value",
        "P2 1.J, A 1.1, C",
        "P2, H8 and P3 manuals",
    ),
    (
        Command.REVCOUNT,
        Argument.INT,
        Quantity.COUNT,
        "differential encoder ticks of a turn (AROS) or half a turn (ARCOS)",
        "A 1.1, C 1.1",
        "H8 and P3 manuals",
    ),
    (Command.DRIFTFACTOR, Argument.INT, Quantity.COUNT, "1/8192 added to the left encoder", "C 1.0", "P3 manual"),
    (Command.SOUND, Argument.INT, Quantity.COUNT, "play a sound", "AmigOS", "Amigo manual"),
    (
        Command.PLAYLIST,
        Argument.INT,
        Quantity.COUNT,
        "request the sound list, 0 all",
        "P2 1.E, A 1.0, AmigOS",
        "P2, H8 and Amigo manuals",
    ),
    (Command.SOUNDTOG, Argument.INT, Quantity.COUNT, "0 mute, 1 enable the buzzer", "A 1.0, C", "H8 and P3 manuals"),
    (Command.TICKSMM, Argument.INT, Quantity.COUNT, "encoder ticks per mm", "C 1.1", "P3 manual"),
    (Command.POWER_PC, Argument.INT, Quantity.COUNT, "power output", "library", "client library"),
    (Command.POWER_LRF, Argument.INT, Quantity.COUNT, "power output", "library", "client library"),
    (Command.POWER_5V, Argument.INT, Quantity.COUNT, "power output", "library", "client library"),
    (
        Command.POWER_12V,
        Argument.INT,
        Quantity.COUNT,
        "power output (24 V on some robots)",
        "library",
        "client library",
    ),
    (Command.LATVEL, Argument.INT, Quantity.SPEED, "translate sideways", "Seekur", "client library"),
    (
        Command.LATACCEL,
        Argument.INT,
        Quantity.ACCELERATION,
        "positive: lateral acceleration; negative: deceleration",
        "Seekur",
        "client library",
    ),
    (
        Command.RECENTERWHEELS,
        Argument.NONE,
        Quantity.COUNT,
        "steer the wheels straight",
        "library (Seekur)",
        "client library",
    ),
    (Command.ACCELINFO, Argument.INT, Quantity.COUNT, "accelerometer packets: 0, 1, 2", "MTX", "client library"),
    (Command.TORQUEINFO, Argument.INT, Quantity.COUNT, "torque packets: 0, 1, 2", "MTX", "client library"),
    (Command.POWER_AUX_PC, Argument.INT, Quantity.COUNT, "power output", "MTX", "client library"),
    (Command.POWER_TOUCHSCREEN, Argument.INT, Quantity.COUNT, "power output", "MTX", "client library"),
    (Command.POWER_PTZ, Argument.INT, Quantity.COUNT, "power output", "MTX", "client library"),
    (Command.POWER_AUDIO, Argument.INT, Quantity.COUNT, "power output", "MTX", "client library"),
    (Command.POWER_LRF2, Argument.INT, Quantity.COUNT, "power output", "MTX", "client library"),
    (Command.HEADINGINFO, Argument.INT, Quantity.COUNT, "heading packets", "MTX", "client library"),
    (
        Command.ROTVEL_CLOSEDLOOP_ENABLE,
        Argument.INT,
        Quantity.COUNT,
        "closed loop of the rotational speed",
        "MTX",
        "client library",
    ),
    (Command.SRECORD, Argument.DATA, Quantity.COUNT, "controller maintenance", "library (MTX)", "client library"),
    (Command.MARCDEBUG, Argument.DATA, Quantity.COUNT, "debug text", "library (MTX)", "client library"),
    (Command.WHEEL_LIGHT, Argument.DATA, Quantity.COUNT, "wheel lights", "library (MTX)", "client library"),
    (Command.ABSOLUTE_MAXES, Argument.DATA, Quantity.COUNT, "absolute limits", "library (MTX)", "client library"),
    (
        Command.SAFETY_STATE_INFO,
        Argument.DATA,
        Quantity.COUNT,
        "state of the safety system",
        "library (MTX)",
        "client library",
    ),
    (
        Command.SAFETY_SET_STATE,
        Argument.DATA,
        Quantity.COUNT,
        "set the safety system",
        "library (MTX)",
        "client library",
    ),
    (
        Command.SAFETY_DISABLE_POWER_OFF_TIMER,
        Argument.DATA,
        Quantity.COUNT,
        "safety system",
        "library (MTX)",
        "client library",
    ),
    (Command.SAFETY_ZONE_ACTIVE, Argument.DATA, Quantity.COUNT, "safety system", "library (MTX)", "client library"),
    (Command.WHEELINFO_REQUEST, Argument.DATA, Quantity.COUNT, "wheel packets", "library (MTX)", "client library"),
    (
        Command.MARC_CONFIG_SET,
        Argument.DATA,
        Quantity.COUNT,
        "controller configuration",
        "library (MTX)",
        "client library",
    ),
    (
        Command.MARC_CONFIG_GET,
        Argument.DATA,
        Quantity.COUNT,
        "controller configuration",
        "library (MTX)",
        "client library",
    ),
    (
        Command.SIM_SET_POSE,
        Argument.DATA,
        Quantity.COUNT,
        "i32 x mm, i32 y mm, i32 heading deg: move the true pose",
        "simulator",
        "client library (simulator commands)",
    ),
    (
        Command.SIM_RESET,
        Argument.NONE,
        Quantity.COUNT,
        "reset pose and odometry",
        "simulator",
        "client library (simulator commands)",
    ),
    (
        Command.SIM_MODEL_CONFIG,
        Argument.DATA,
        Quantity.COUNT,
        "model configuration",
        "simulator",
        "client library (simulator commands)",
    ),
    (
        Command.SIM_LRF_ENABLE,
        Argument.INT,
        Quantity.COUNT,
        "laser in the robot's line: 0 off, 1 on, 2 extended",
        "simulator",
        "client library (simulator commands)",
    ),
    (
        Command.SIM_LRF_SET_FOV_START,
        Argument.INT,
        Quantity.ANGLE,
        "first bearing",
        "simulator",
        "client library (simulator commands)",
    ),
    (
        Command.SIM_LRF_SET_FOV_END,
        Argument.INT,
        Quantity.ANGLE,
        "last bearing",
        "simulator",
        "client library (simulator commands)",
    ),
    (
        Command.SIM_LRF_SET_RES,
        Argument.INT,
        Quantity.ANGLE,
        "between two bearings",
        "simulator",
        "client library (simulator commands)",
    ),
    (
        Command.SIM_CTRL,
        Argument.DATA,
        Quantity.COUNT,
        "i16 operation and its data",
        "simulator",
        "client library (simulator commands)",
    ),
    (
        Command.SIM_STAT,
        Argument.INT,
        Quantity.COUNT,
        "SIMSTAT packets: 0 stop, 1 one, 2 continuous",
        "simulator",
        "client library (simulator commands)",
    ),
    (Command.SIM_MESSAGE, Argument.STRING, Quantity.COUNT, "text", "simulator", "client library (simulator commands)"),
    (
        Command.SIM_EXIT,
        Argument.INT,
        Quantity.COUNT,
        "leave with an exit code",
        "simulator",
        "client library (simulator commands)",
    ),
    (
        Command.BATTEST,
        Argument.INT,
        Quantity.VOLTAGE,
        "ARCOS: pretend a battery voltage, 0 the real one (AROS: SHUTDOWN 0, 1, 2)",
        "A 1.6, C 1.0",
        "H8 and P3 manuals",
    ),
    (Command.DIGTEMPTEST, Argument.INT, Quantity.COUNT, "pretend a temperature warning", "simulator", "client library"),
    (Command.SPOOFANALOGTEMP, Argument.INT, Quantity.COUNT, "pretend a temperature", "simulator", "client library"),
    (Command.RESET, Argument.NONE, Quantity.COUNT, "reset the controller as power-on does", "C 1.0", "P3 manual"),
    (Command.MAINTENANCE, Argument.NONE, Quantity.COUNT, "enter maintenance mode", "C 1.0", "P3 manual"),
)

COMMANDS: Mapping[int, CommandSpec] = {
    command.value: CommandSpec(command.value, command.name, argument, quantity, meaning, since, source)
    for command, argument, quantity, meaning, since, source in _ROWS
}
"""The table by command number."""

"""The command table: number, name, argument, quantity, meaning, since when, and where that is written.

Sources are the fact sheet's. Since when: `P2` P2OS, `A` AROS, `C` ARCOS with the version that brought a command in, where a
manual says so; `library` means seen in a client library only.
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
        "section 3",
    ),
    (
        Command.SYNC1,
        Argument.NONE,
        Quantity.COUNT,
        "handshake; OPEN once synchronised: starts the servers",
        "all",
        "section 3",
    ),
    (
        Command.SYNC2,
        Argument.NONE,
        Quantity.COUNT,
        "handshake; CLOSE once connected: stops the servers",
        "all",
        "section 3",
    ),
    (
        Command.POLLING,
        Argument.STRING,
        Quantity.COUNT,
        "sonar firing sequence, numbers 1 to 32; empty disables all sonar",
        "P2 1.0, A 1.0, C",
        "section 4",
    ),
    (Command.ENABLE, Argument.INT, Quantity.COUNT, "1 enable, 0 disable the motors", "P2 1.0, A 1.0", "section 4"),
    (
        Command.SETA,
        Argument.INT,
        Quantity.ACCELERATION,
        "positive: translational acceleration; negative: deceleration",
        "P2 1.0, A 1.0",
        "section 4",
    ),
    (Command.SETV, Argument.INT, Quantity.SPEED, "maximum translational speed", "P2 1.0, A 1.0", "section 4"),
    (Command.SETO, Argument.NONE, Quantity.COUNT, "reset odometry to zero", "all", "section 4"),
    (Command.MOVE, Argument.INT, Quantity.LENGTH, "translate from here", "P2, A 1.0", "section 4"),
    (Command.ROTATE, Argument.INT, Quantity.ROTATION, "rotate, as RVEL", "A 1.0", "section 4"),
    (Command.SETRV, Argument.INT, Quantity.ROTATION, "maximum rotational speed", "P2 1.0", "section 4"),
    (Command.VEL, Argument.INT, Quantity.SPEED, "translate at a speed", "all", "section 4"),
    (Command.HEAD, Argument.INT, Quantity.ANGLE, "turn to an absolute heading, counter-clockwise", "all", "section 4"),
    (Command.DHEAD, Argument.INT, Quantity.ANGLE, "turn relative to the present heading", "all", "section 4"),
    (
        Command.SETRV_DIRECTIONAL,
        Argument.INT,
        Quantity.ROTATION,
        "positive: counter-clockwise maximum; negative: clockwise maximum",
        "C 2.x",
        "section 4, ARCOS 2.8 readme",
    ),
    (Command.SAY, Argument.STRING, Quantity.COUNT, "up to 20 pairs of duration (20 ms) and tone", "all", "section 4"),
    (Command.JOYREQUEST, Argument.INT, Quantity.COUNT, "JOYSTICKpac: 0 stop, 1 one, 2 continuous", "C", "section 4"),
    (Command.CONFIG, Argument.NONE, Quantity.COUNT, "request a CONFIGpac", "P2 1.4", "section 4"),
    (
        Command.ENCODER,
        Argument.INT,
        Quantity.COUNT,
        "ENCODERpac: 0 stop, 1 one, 2 and more continuous",
        "P2 1.4",
        "section 4",
    ),
    (Command.SETRVDIR, Argument.INT, Quantity.ROTATION, "as 14, by another number", "library", "section 4"),
    (Command.RVEL, Argument.INT, Quantity.ROTATION, "rotate at a speed, counter-clockwise", "all", "section 4"),
    (Command.DCHEAD, Argument.INT, Quantity.ANGLE, "turn relative to the last heading setpoint", "P2", "section 4"),
    (
        Command.SETRA,
        Argument.INT,
        Quantity.ANGULAR_ACCELERATION,
        "positive: rotational acceleration; negative: deceleration",
        "P2 1.0",
        "section 4",
    ),
    (Command.IMUREQUEST, Argument.INT, Quantity.COUNT, "IMU packets: 0, 1, 2", "library (Seekur)", "section 4"),
    (
        Command.SONAR,
        Argument.INT,
        Quantity.COUNT,
        "bit 0: enable or disable; bits 1-3: array 1 to 4, 0 all",
        "P2 1.0, A, C",
        "section 4",
    ),
    (Command.STOP, Argument.NONE, Quantity.COUNT, "stop, the motors stay enabled", "P2, A", "section 4"),
    (
        Command.DIGOUT,
        Argument.TWO_BYTES,
        Quantity.COUNT,
        "high byte: mask of outputs to change; low byte: values",
        "P2 1.2",
        "section 4",
    ),
    (
        Command.SETPBIOPORT,
        Argument.TWO_BYTES,
        Quantity.COUNT,
        "likewise for the power outputs of PatrolBot and PowerBot",
        "library",
        "section 4",
    ),
    (
        Command.VEL2,
        Argument.TWO_BYTES,
        Quantity.COUNT,
        "high byte: left wheel, low byte: right wheel, signed, in the model's VEL2 unit",
        "P2, A, C 1.1",
        "section 4",
    ),
    (Command.GRIPPER, Argument.INT, Quantity.COUNT, "gripper server command", "P2", "section 4"),
    (Command.ADSEL, Argument.INT, Quantity.COUNT, "analog port that the SIP reports", "C 1.0", "section 4"),
    (Command.GRIPPERVAL, Argument.INT, Quantity.COUNT, "value for the preceding GRIPPER", "P2", "section 4"),
    (Command.GRIPREQUEST, Argument.INT, Quantity.COUNT, "GRIPPERpac: 0, 1, 2 and more", "A, C 1.0", "section 4"),
    (Command.GYROCALCW, Argument.UINT, Quantity.COUNT, "gyro calibration, clockwise", "C 2.0", "section 4"),
    (Command.GYROCALCCW, Argument.UINT, Quantity.COUNT, "gyro calibration, counter-clockwise", "C 2.0", "section 4"),
    (
        Command.IOREQUEST,
        Argument.INT,
        Quantity.COUNT,
        "IOpac: 0 stop, 1 one, 2 and more continuous",
        "P2 1.E",
        "section 4",
    ),
    (
        Command.PTUPOS,
        Argument.TWO_BYTES,
        Quantity.COUNT,
        "high byte: servo port 1 to 4; low byte: pulse width",
        "PSOS 4.5, P2 1.2",
        "section 4",
    ),
    (Command.TTY2, Argument.STRING, Quantity.COUNT, "send bytes out of AUX1", "P2 1.0", "section 4"),
    (Command.GETAUX, Argument.UINT, Quantity.COUNT, "return so many bytes from AUX1; 0 flushes", "P2 1.4", "section 4"),
    (
        Command.BUMPSTALL,
        Argument.INT,
        Quantity.COUNT,
        "stall on contact: 0 none, 1 front, 2 rear, 3 both",
        "P2 1.5, C",
        "section 4",
    ),
    (Command.TCM2, Argument.INT, Quantity.COUNT, "compass module mode", "P2 1.6", "section 4"),
    (
        Command.DOCK,
        Argument.INT,
        Quantity.COUNT,
        "0 off, 1 docking signals, 2 and stop when power is sensed",
        "P2 1.C",
        "section 4",
    ),
    (
        Command.JOYDRIVE,
        Argument.INT,
        Quantity.COUNT,
        "1 allows joystick driving while connected",
        "P2 1.G",
        "section 4",
    ),
    (
        Command.SONARCYCLE,
        Argument.UINT,
        Quantity.DURATION,
        "time from one sonar firing to the next",
        "A 1.8, C",
        "section 4",
    ),
    (Command.MOVINGBLINK, Argument.INT, Quantity.COUNT, "PatrolBot lamp", "library", "section 4"),
    (
        Command.HOSTBAUD,
        Argument.INT,
        Quantity.COUNT,
        "host rate by code: 0 9600, 1 19200, 2 38400, 3 57600, 4 115200",
        "A, C 1.0",
        "section 2",
    ),
    (Command.AUX1BAUD, Argument.INT, Quantity.COUNT, "AUX1 rate, likewise", "A, C 1.0", "section 2"),
    (Command.AUX2BAUD, Argument.INT, Quantity.COUNT, "AUX2 rate, likewise", "A, C 1.0", "section 2"),
    (Command.AUX3BAUD, Argument.INT, Quantity.COUNT, "AUX3 rate, likewise", "A, C 1.0", "section 2"),
    (
        Command.ESTOP,
        Argument.NONE,
        Quantity.COUNT,
        "emergency stop, ignores the deceleration limit",
        "P2 1.8",
        "section 4",
    ),
    (
        Command.ESTALL,
        Argument.INT,
        Quantity.COUNT,
        "1: the STOP button stalls and disables the motors",
        "P2 1.E",
        "section 4",
    ),
    (Command.ESTOP_ALIAS, Argument.NONE, Quantity.COUNT, "as 55", "simulator", "section 4"),
    (Command.GYRO, Argument.INT, Quantity.COUNT, "gyro packets: 1 on, 0 off", "A 1.8", "section 4"),
    (
        Command.LCDWRITE,
        Argument.STRING,
        Quantity.COUNT,
        "text for the LCD accessory",
        "C (number unverified)",
        "section 4",
    ),
    (Command.TTY4, Argument.STRING, Quantity.COUNT, "send bytes out of AUX3", "C 1.0", "section 4"),
    (Command.GETAUX3, Argument.UINT, Quantity.COUNT, "as GETAUX for AUX3", "C 1.0", "section 4"),
    (Command.BATTERYINFO, Argument.INT, Quantity.COUNT, "battery packets: 0, 1, 2", "library", "section 4"),
    (Command.LOADWORLD, Argument.STRING, Quantity.COUNT, "an older simulator's command", "library", "section 4"),
    (Command.STEP, Argument.NONE, Quantity.COUNT, "single step, simulator only", "PSOS 3.x, P2 1.0", "section 4"),
    (Command.CALCOMP, Argument.INT, Quantity.COUNT, "compass calibration", "library", "section 4"),
    (Command.TTY3, Argument.STRING, Quantity.COUNT, "send bytes out of AUX2", "C 1.0, AmigOS 1.3", "section 4"),
    (Command.GETAUX2, Argument.UINT, Quantity.COUNT, "as GETAUX for AUX2", "A 1.1, C 1.0, AmigOS 1.3", "section 4"),
    (
        Command.CHARGE,
        Argument.INT,
        Quantity.COUNT,
        "1 deploy, 0 release the automatic charger",
        "A 1.7, C 1.0",
        "section 4",
    ),
    (Command.RESETSIMTOORIGIN, Argument.NONE, Quantity.COUNT, "an older simulator's command", "library", "section 4"),
    (Command.ARM_INFO, Argument.NONE, Quantity.COUNT, "request an ARMINFOpac", "P2 1.H, A 1.3, C 1.1", "section 4"),
    (
        Command.ARM_STATUS,
        Argument.INT,
        Quantity.COUNT,
        "ARMpac: 0 stop, 1 one, 2 continuous",
        "P2 1.H, A 1.3, C 1.1",
        "section 4",
    ),
    (Command.ARM_INIT, Argument.NONE, Quantity.COUNT, "initialise the arm", "P2 1.H, A 1.3, C 1.1", "section 4"),
    (Command.ARM_CHECK, Argument.NONE, Quantity.COUNT, "look for the arm", "P2 1.H, A 1.3, C 1.1", "section 4"),
    (Command.ARM_POWER, Argument.INT, Quantity.COUNT, "arm power on or off", "P2 1.H, A 1.3, C 1.1", "section 4"),
    (Command.ARM_HOME, Argument.INT, Quantity.COUNT, "home a joint", "P2 1.H, A 1.3, C 1.1", "section 4"),
    (Command.ARM_PARK, Argument.NONE, Quantity.COUNT, "park the arm", "P2 1.H, A 1.3, C 1.1", "section 4"),
    (Command.ARM_POS, Argument.TWO_BYTES, Quantity.COUNT, "move a joint", "P2 1.H, A 1.3, C 1.1", "section 4"),
    (Command.ARM_SPEED, Argument.TWO_BYTES, Quantity.COUNT, "speed of a joint", "P2 1.H, A 1.3, C 1.1", "section 4"),
    (Command.ARM_STOP, Argument.INT, Quantity.COUNT, "stop a joint", "P2 1.H, A 1.3, C 1.1", "section 4"),
    (
        Command.ARM_AUTOPARK,
        Argument.INT,
        Quantity.COUNT,
        "time without command before parking",
        "P2 1.H, A 1.3, C 1.1",
        "section 4",
    ),
    (
        Command.ARM_GRIPPARK,
        Argument.INT,
        Quantity.COUNT,
        "gripper position when parked",
        "P2 1.H, A 1.3, C 1.1",
        "section 4",
    ),
    (Command.ROTKP, Argument.INT, Quantity.COUNT, "rotational gain KP, working value", "P2 1.J, A 1.1, C", "section 4"),
    (Command.ROTKV, Argument.INT, Quantity.COUNT, "rotational gain KV, working value", "P2 1.J, A 1.1, C", "section 4"),
    (Command.ROTKI, Argument.INT, Quantity.COUNT, "rotational gain KI, working value", "P2 1.J, A 1.1, C", "section 4"),
    (
        Command.TRANSKP,
        Argument.INT,
        Quantity.COUNT,
        "translational gain KP, working value",
        "P2 1.J, A 1.1, C",
        "section 4",
    ),
    (
        Command.TRANSKV,
        Argument.INT,
        Quantity.COUNT,
        "translational gain KV, working value",
        "P2 1.J, A 1.1, C",
        "section 4",
    ),
    (
        Command.TRANSKI,
        Argument.INT,
        Quantity.COUNT,
        "translational gain KI, working value",
        "P2 1.J, A 1.1, C",
        "section 4",
    ),
    (
        Command.REVCOUNT,
        Argument.INT,
        Quantity.COUNT,
        "differential encoder ticks of a turn (AROS) or half a turn (ARCOS)",
        "A 1.1, C 1.1",
        "section 4",
    ),
    (Command.DRIFTFACTOR, Argument.INT, Quantity.COUNT, "1/8192 added to the left encoder", "C 1.0", "section 4"),
    (Command.SOUND, Argument.INT, Quantity.COUNT, "play a sound", "AmigOS", "section 4"),
    (
        Command.PLAYLIST,
        Argument.INT,
        Quantity.COUNT,
        "request the sound list, 0 all",
        "P2 1.E, A 1.0, AmigOS",
        "section 4",
    ),
    (Command.SOUNDTOG, Argument.INT, Quantity.COUNT, "0 mute, 1 enable the buzzer", "A 1.0, C", "section 4"),
    (Command.TICKSMM, Argument.INT, Quantity.COUNT, "encoder ticks per mm", "C 1.1", "section 4"),
    (Command.POWER_PC, Argument.INT, Quantity.COUNT, "power output", "library", "section 4"),
    (Command.POWER_LRF, Argument.INT, Quantity.COUNT, "power output", "library", "section 4"),
    (Command.POWER_5V, Argument.INT, Quantity.COUNT, "power output", "library", "section 4"),
    (Command.POWER_12V, Argument.INT, Quantity.COUNT, "power output (24 V on some robots)", "library", "section 4"),
    (Command.LATVEL, Argument.INT, Quantity.SPEED, "translate sideways", "Seekur", "section 4"),
    (
        Command.LATACCEL,
        Argument.INT,
        Quantity.ACCELERATION,
        "positive: lateral acceleration; negative: deceleration",
        "Seekur",
        "section 4",
    ),
    (
        Command.RECENTERWHEELS,
        Argument.NONE,
        Quantity.COUNT,
        "steer the wheels straight",
        "library (Seekur)",
        "section 4",
    ),
    (Command.ACCELINFO, Argument.INT, Quantity.COUNT, "accelerometer packets: 0, 1, 2", "MTX", "section 4"),
    (Command.TORQUEINFO, Argument.INT, Quantity.COUNT, "torque packets: 0, 1, 2", "MTX", "section 4"),
    (Command.POWER_AUX_PC, Argument.INT, Quantity.COUNT, "power output", "MTX", "section 4"),
    (Command.POWER_TOUCHSCREEN, Argument.INT, Quantity.COUNT, "power output", "MTX", "section 4"),
    (Command.POWER_PTZ, Argument.INT, Quantity.COUNT, "power output", "MTX", "section 4"),
    (Command.POWER_AUDIO, Argument.INT, Quantity.COUNT, "power output", "MTX", "section 4"),
    (Command.POWER_LRF2, Argument.INT, Quantity.COUNT, "power output", "MTX", "section 4"),
    (Command.HEADINGINFO, Argument.INT, Quantity.COUNT, "heading packets", "MTX", "section 4"),
    (
        Command.ROTVEL_CLOSEDLOOP_ENABLE,
        Argument.INT,
        Quantity.COUNT,
        "closed loop of the rotational speed",
        "MTX",
        "section 4",
    ),
    (Command.SRECORD, Argument.DATA, Quantity.COUNT, "controller maintenance", "library (MTX)", "section 4"),
    (Command.MARCDEBUG, Argument.DATA, Quantity.COUNT, "debug text", "library (MTX)", "section 4"),
    (Command.WHEEL_LIGHT, Argument.DATA, Quantity.COUNT, "wheel lights", "library (MTX)", "section 4"),
    (Command.ABSOLUTE_MAXES, Argument.DATA, Quantity.COUNT, "absolute limits", "library (MTX)", "section 4"),
    (
        Command.SAFETY_STATE_INFO,
        Argument.DATA,
        Quantity.COUNT,
        "state of the safety system",
        "library (MTX)",
        "section 4",
    ),
    (Command.SAFETY_SET_STATE, Argument.DATA, Quantity.COUNT, "set the safety system", "library (MTX)", "section 4"),
    (
        Command.SAFETY_DISABLE_POWER_OFF_TIMER,
        Argument.DATA,
        Quantity.COUNT,
        "safety system",
        "library (MTX)",
        "section 4",
    ),
    (Command.SAFETY_ZONE_ACTIVE, Argument.DATA, Quantity.COUNT, "safety system", "library (MTX)", "section 4"),
    (Command.WHEELINFO_REQUEST, Argument.DATA, Quantity.COUNT, "wheel packets", "library (MTX)", "section 4"),
    (Command.MARC_CONFIG_SET, Argument.DATA, Quantity.COUNT, "controller configuration", "library (MTX)", "section 4"),
    (Command.MARC_CONFIG_GET, Argument.DATA, Quantity.COUNT, "controller configuration", "library (MTX)", "section 4"),
    (
        Command.SIM_SET_POSE,
        Argument.DATA,
        Quantity.COUNT,
        "i32 x mm, i32 y mm, i32 heading deg: move the true pose",
        "simulator",
        "section 7",
    ),
    (Command.SIM_RESET, Argument.NONE, Quantity.COUNT, "reset pose and odometry", "simulator", "section 7"),
    (Command.SIM_MODEL_CONFIG, Argument.DATA, Quantity.COUNT, "model configuration", "simulator", "section 7"),
    (
        Command.SIM_LRF_ENABLE,
        Argument.INT,
        Quantity.COUNT,
        "laser in the robot's line: 0 off, 1 on, 2 extended",
        "simulator",
        "section 7",
    ),
    (Command.SIM_LRF_SET_FOV_START, Argument.INT, Quantity.ANGLE, "first bearing", "simulator", "section 7"),
    (Command.SIM_LRF_SET_FOV_END, Argument.INT, Quantity.ANGLE, "last bearing", "simulator", "section 7"),
    (Command.SIM_LRF_SET_RES, Argument.INT, Quantity.ANGLE, "between two bearings", "simulator", "section 7"),
    (Command.SIM_CTRL, Argument.DATA, Quantity.COUNT, "i16 operation and its data", "simulator", "section 7"),
    (
        Command.SIM_STAT,
        Argument.INT,
        Quantity.COUNT,
        "SIMSTAT packets: 0 stop, 1 one, 2 continuous",
        "simulator",
        "section 7",
    ),
    (Command.SIM_MESSAGE, Argument.STRING, Quantity.COUNT, "text", "simulator", "section 7"),
    (Command.SIM_EXIT, Argument.INT, Quantity.COUNT, "leave with an exit code", "simulator", "section 7"),
    (
        Command.BATTEST,
        Argument.INT,
        Quantity.VOLTAGE,
        "ARCOS: pretend a battery voltage, 0 the real one (AROS: SHUTDOWN 0, 1, 2)",
        "A 1.6, C 1.0",
        "section 4",
    ),
    (Command.DIGTEMPTEST, Argument.INT, Quantity.COUNT, "pretend a temperature warning", "simulator", "section 4"),
    (Command.SPOOFANALOGTEMP, Argument.INT, Quantity.COUNT, "pretend a temperature", "simulator", "section 4"),
    (Command.RESET, Argument.NONE, Quantity.COUNT, "reset the controller as power-on does", "C 1.0", "section 4"),
    (Command.MAINTENANCE, Argument.NONE, Quantity.COUNT, "enter maintenance mode", "C 1.0", "section 4"),
)

COMMANDS: Mapping[int, CommandSpec] = {
    command.value: CommandSpec(command.value, command.name, argument, quantity, meaning, since, source)
    for command, argument, quantity, meaning, since, source in _ROWS
}
"""The table by command number."""

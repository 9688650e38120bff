"""What the protocol sheet calls unverified: how to ask a robot, and how this project reads the matter meanwhile.

Nothing here is right or wrong. The bytes that a real robot answers are written to a report that its owner can send
back (`--report FILE`); see test_questions.
"""

from dataclasses import dataclass

from pty_tests.client import CLOSE, CONFIG, ENABLE, IOREQUEST, OPEN, POLLING, SETV, SONAR, VEL, command, frame

SYNC = tuple(frame(bytes([number])) for number in range(3))
GREETING = (*SYNC, frame(bytes([OPEN])))


@dataclass(frozen=True, slots=True)
class Question:
    """One unverified matter.

    name: short, for the report. asks: what is not known. reading: how this project reads it meanwhile.
    send: frames, one after the other; between two of them whatever comes is taken down for `pause` seconds.
    listen: s to listen after the last one.
    connected: asked of a robot in conversation; else of one that waits for a handshake.
    moves: the wheels may turn.
    """

    name: str
    asks: str
    reading: str
    send: tuple[bytes, ...]
    listen: float = 0.6
    pause: float = 0.3
    connected: bool = True
    moves: bool = False


QUESTIONS = (
    Question(
        "sync-out-of-turn",
        "what answers a SYNC out of its turn, and whether 0xFF ever does",
        "ignored; SYNC0 restarts the sequence",
        (SYNC[1], SYNC[2], SYNC[0], SYNC[2], SYNC[1], SYNC[1], SYNC[2]),
        connected=False,
    ),
    Question(
        "settings-after-close",
        "whether a working parameter outlives CLOSE (TRANSVELMAX of the second CONFIGpac)",
        "CLOSE brings FLASH back",
        (command(SETV, 321), command(CONFIG), command(CLOSE), *GREETING, command(CONFIG)),
    ),
    Question(
        "configuration",
        "where this firmware's CONFIGpac ends",
        "at the field its family's table names",
        (command(CONFIG),),
    ),
    Question(
        "standard-sip",
        "where this firmware's SIP ends, its FAULTFLAGS, COMPASS and the two gripper bytes at rest",
        "AROS and P2OS end after DIGOUT, ARCOS after FAULTFLAGS",
        (command(SONAR, 0),),
    ),
    Question(
        "io-packet",
        "which digital input byte is which, how many analog words follow, and the idle state of infrared bits",
        "user inputs, front bumpers, rear bumpers, infrared; the battery's word comes last",
        (command(IOREQUEST, 1),),
    ),
    Question(
        "sonar-slots",
        "whether empty slots are ever reported (PowerBot: 7, 15, 23, 31)",
        "never",
        (command(SONAR, 1),),
        listen=2.0,
    ),
    Question(
        "polling-in-text",
        "whether POLLING takes numbers as text as well as binary",
        "binary only",
        (command(SONAR, 1), command(POLLING, b"\x03"), command(POLLING, b"5"), command(SONAR, 0)),
        pause=1.0,
    ),
    Question(
        "lcd-number",
        "whether LCDWRITE is number 59",
        "it is",
        (command(59, b"\x00\x00\x00row 59"),),
    ),
    Question("gripper", "GRIPPERpac with and without a gripper", "type 0 where there is none", (command(37, 1),)),
    Question(
        "joystick",
        "length and order of the JOYSTICKpac",
        "two buttons, X, Y, throttle",
        (command(17, 1), command(17, 0)),
    ),
    Question("gyro", "rest value and count of a GYROpac", "four samples about 512", (command(58, 1), command(58, 0))),
    Question("compass", "TCM2pac, and the COMPASS byte beside it", "half degrees from the heading", (command(45, 2),)),
    Question(
        "arm",
        "ARMINFOpac and the order of the two status bytes of an ARMpac",
        "as ARIA reads them",
        (command(70), command(71, 1)),
    ),
    Question("sounds", "PLAYLISTpac", "one packet a sound, the number of sounds first", (command(91, 0),)),
    Question(
        "batteries", "whether BATTERYINFO is answered", "only where batteries report", (command(62, 1), command(62, 0))
    ),
    Question(
        "directional-limit",
        "whether 14 or 20 is the directional SETRV (ROTVELMAX of the two CONFIGpacs)",
        "both",
        (command(14, 33), command(CONFIG), command(20, 34), command(CONFIG)),
    ),
    Question(
        "aux-empty",
        "what GETAUX answers when nothing has come",
        "nothing",
        (command(43, 0), command(43, 4), command(43, 0)),
    ),
    Question(
        "simulator-commands",
        "whether commands of simulators (63, 64, 69, 224 to 239) have any effect on a real robot",
        "none",
        (*(command(number) for number in (64, 69, 225)), command(237, 1), command(237, 0)),
        pause=0.15,
    ),
    Question(
        "setpoints-while-disabled",
        "whether a velocity given while the motors are off is remembered when they come on",
        "it is forgotten",
        (command(ENABLE, 0), command(VEL, 100), command(ENABLE, 1), command(VEL, 0), command(ENABLE, 0)),
        moves=True,
    ),
)
"""Not asked: MAINTENANCE (255) and commands that write FLASH; they can put a controller out of use."""

LASER_QUESTIONS = (
    Question(
        "laser-stop",
        "ACK bytes before the answer, and the status byte",
        "no ACK byte; 0x10",
        (bytes.fromhex("02 00 02 00 20 25 35 08"),),
    ),
    Question("laser-type", "the type telegram", "a type string", (bytes.fromhex("02 00 01 00 3A 1E 12"),)),
    Question(
        "laser-status",
        "the 152 bytes of the status telegram",
        "angle and resolution where Player reads them",
        (bytes.fromhex("02 00 01 00 31 15 12"),),
    ),
    Question(
        "laser-configuration",
        "the configuration telegram",
        "as Player edits it",
        (bytes.fromhex("02 00 01 00 74 50 12"),),
    ),
    Question(
        "laser-damaged",
        "what answers a telegram with a wrong checksum",
        "nothing, or NAK 15",
        (bytes.fromhex("02 00 02 00 20 25 FF FF"),),
    ),
)
"""For a SICK LMS200 on a port of its own (`--laser PORT`), at 9600 bit/s as after its power switch."""

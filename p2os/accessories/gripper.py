"""Values of GRIPPER, GRIPPERVAL and GRIPPERpac, and the bits of a gripper in the SIP.

Source: gripper manual (commands, state byte, digital inputs), and the client libraries for which byte of the SIP means
what.
"""

from enum import IntEnum, IntFlag


class GripperOrder(IntEnum):
    """Arguments of GRIPPER. STOP stops the paddles, LIFT_STOP the lift, HALT both; what is held stays held."""

    OPEN = 1
    CLOSE = 2
    STOP = 3
    UP = 4
    DOWN = 5
    LIFT_STOP = 6
    STORE = 7
    DEPLOY = 8
    HALT = 15
    PRESS = 16
    CARRY = 17


class GripperFlags(IntFlag):
    """Bits of the state byte; both bits of a pair are set while the position is unknown."""

    PADDLES_OPEN = 1 << 0
    PADDLES_CLOSED = 1 << 1
    PADDLES_MOVING = 1 << 2
    PADDLES_ERROR = 1 << 3
    LIFT_UP = 1 << 4
    LIFT_DOWN = 1 << 5
    LIFT_MOVING = 1 << 6
    LIFT_ERROR = 1 << 7

    @classmethod
    def of(cls, paddles: int, lift: int) -> "GripperFlags":
        """Return the state for the bits of paddles and lift, both counted as those of the paddles."""
        return cls(paddles | lift << _LIFT_SHIFT)


_LIFT_SHIFT = 4


class GripperInput(IntFlag):
    """Bits of the digital inputs with a gripper on them; contacts are 0 when something presses.

    A PeopleBot's gripper alone shows what moves here.
    """

    PADDLES_BETWEEN = 1 << 0
    LIFT_BETWEEN = 1 << 1
    OUTER_BEAM = 1 << 2
    INNER_BEAM = 1 << 3
    LEFT_CONTACT = 1 << 4
    RIGHT_CONTACT = 1 << 5
    LIFT_MOVING = 1 << 6
    PADDLES_MOVING = 1 << 7


class GripperKind(IntEnum):
    """Kind of gripper in a GRIPPERpac: a Pioneer's is wired to the user I/O, a PeopleBot's to the general I/O."""

    NONE = 0
    PIONEER = 1
    PEOPLEBOT = 2


USER_INPUTS = 0x3F
"""The user inputs that a gripper on the user I/O takes."""
INTERVAL = 0.02
"""s; GRIPPERVAL counts in it."""
LONGEST_PRESS, LONGEST_CARRY = 100, 255
"""The most that GRIPPERVAL carries for PRESS and for CARRY."""

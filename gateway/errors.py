"""Errors of the gateway and their exit codes.

    GatewayError                       1
     +-- NameNotValid                  2   no key on the bus could begin with that name
     +-- NoSuchPort                    3   nothing there
     +-- NotAPort                      4   a directory, a file
     +-- PortForbidden                 5   no permission; the message names the group
     +-- PortBusy                      6   another program has it
     +-- RobotSilent (TimeoutError)    7   no byte at any rate
     +-- NotARobot                     8   something answers, but not in P2OS packets
     +-- UnknownModel                  9   a robot, but none that configs/robots knows
     +-- WrongRobot                    10  another robot than the one before
     +-- NameInUse                     11  another gateway on the bus has the robot's name
     +-- PortLost (ConnectionError)        the port was there and is gone; the bridge waits for it
     +-- CameraNotUsable               2   no camera could be opened in that way
     +-- CommandRefused                    a command that the robot must not be given now, or ever
          +-- LineBlocked                  the port hangs

Exit code 2 is any other usage or configuration error too, and 0 an end by signal.
"""

from typing import ClassVar


class GatewayError(Exception):
    """Base class of the errors of a gateway. The message says what happened and what to do."""

    exit_code: ClassVar[int] = 1


class RobotNameNotValid(GatewayError):
    """The name cannot be part of a key on the bus."""

    exit_code = 2


class NoSuchPort(GatewayError):
    """There is nothing at that path or address."""

    exit_code = 3


class NotAPort(GatewayError):
    """There is a file or address, but no serial port."""

    exit_code = 4


class PortForbidden(GatewayError):
    """This user may not open the port."""

    exit_code = 5


class PortBusy(GatewayError):
    """Another program holds the port."""

    exit_code = 6


class RobotSilent(GatewayError, TimeoutError):
    """Nothing answered at any rate."""

    exit_code = 7


class NotARobot(GatewayError):
    """Bytes arrived, but no P2OS packet."""

    exit_code = 8


class UnknownModel(GatewayError):
    """The model of the robot is not known."""

    exit_code = 9


class WrongRobot(GatewayError):
    """Another robot answers than the one that this gateway publishes."""

    exit_code = 10


class NameInUse(GatewayError):
    """Another gateway on the bus has the robot's name.

    holder: which one, in words.
    """

    exit_code = 11

    def __init__(self, holder: str) -> None:
        super().__init__(
            f"{holder}; end that one, or give this robot another name (--name) or another bus (--bus local:NAME). With "
            "--force this gateway waits until the other has ended"
        )
        self.holder = holder


class PortLost(GatewayError, ConnectionError):
    """The port was open and is gone."""


class CameraNotOpened(GatewayError):
    """The address of the camera is wrong, or a package for it is missing."""

    exit_code = 2


class CommandRefused(GatewayError):
    """The command is refused; the message says why."""


class LineBlocked(CommandRefused):
    """The port of the robot, or of one of its elements, hangs."""

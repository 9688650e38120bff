"""Errors of the gateway. Those that no code tells from others by their class differ in their exit code only."""

from enum import IntEnum


class ExitCode(IntEnum):
    """Exit codes of `p2os-gateway`; 0 is an end by a signal."""

    FAILED = 1
    USAGE = 2
    NO_PORT = 3
    NOT_A_PORT = 4
    NO_PERMISSION = 5
    PORT_IN_USE = 6
    NO_ANSWER = 7
    NOT_A_ROBOT = 8
    UNKNOWN_MODEL = 9
    WRONG_ROBOT = 10
    NAME_IN_USE = 11


class GatewayError(Exception):
    """An error of a gateway. The message says what happened and what to do.

    exit_code: of the program, if it ends because of the error.
    """

    def __init__(self, message: str, exit_code: ExitCode = ExitCode.FAILED) -> None:
        super().__init__(message)
        self.exit_code = exit_code


class NoSuchPort(GatewayError):
    """There is nothing at that path or address."""

    def __init__(self, message: str) -> None:
        super().__init__(message, ExitCode.NO_PORT)


class PortBusy(GatewayError):
    """Another program holds the port."""

    def __init__(self, message: str) -> None:
        super().__init__(message, ExitCode.PORT_IN_USE)


class NameInUse(GatewayError):
    """Another gateway on the bus has the robot's name.

    holder: which one, in words.
    """

    def __init__(self, holder: str) -> None:
        super().__init__(
            f"{holder}; end that one, or give this robot another name (--name) or another bus (--bus local:NAME). With "
            "--force this gateway waits until the other has ended",
            ExitCode.NAME_IN_USE,
        )
        self.holder = holder


class PortLost(GatewayError, ConnectionError):
    """The port was open and is gone; the bridge opens it again."""


class CommandRefused(GatewayError):
    """The command is refused; the message says why."""


class LineBlocked(CommandRefused):
    """The port of the robot, or of one of its elements, hangs."""

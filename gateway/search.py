"""The search for a robot on a port: rates, model, and the error when there is none."""

from collections.abc import Mapping, Sequence

import configs
from gateway.connector import AS_IT_IS, RATES
from gateway.driver import ModelFinder
from gateway.errors import ExitCode, GatewayError
from gateway.events import Event, HandshakeCompleted, RobotRejected, SweepFailed
from gateway.link_diagnosis import Cause, LinkProblem
from gateway.serial_port import Port
from gateway.settings import Settings
from p2os import Identity, RobotModel

PATIENCE = 2.5
"""Seconds to look for a robot, at the least."""
SWEEPS = 2
"""Times to try every rate, at the least."""
NO_SWEEPS = (Cause.NO_PORT, Cause.HANG_UP)
"""Causes for which no rate is tried to the end."""
FAILURES: Mapping[Cause, ExitCode] = {Cause.NO_PORT: ExitCode.NO_PORT, Cause.NO_ANSWER: ExitCode.NO_ANSWER}
"""The exit code for a cause; it is `NOT_A_ROBOT` for the others."""


def rates_to_try(port: Port, baud: int | None) -> tuple[int, ...]:
    """Return the rates at which to look for the robot, bit/s.

    Args:
        port: Open; the rate that it has is probably the one that the last client used.
        baud: The only one to try; None tries all.
    """
    if port.rate is None:
        return (AS_IT_IS,)
    if baud is not None:
        return (baud,)
    return tuple(sorted(RATES, key=lambda rate: rate != port.rate))


def model_finder(settings: Settings) -> ModelFinder:
    """Return a function that finds the model in `configs/robots`, or the one that the settings name.

    Raises:
        ConfigError: The settings name a model that does not exist.
    """
    named = None if settings.model is None else configs.load(RobotModel, "robots", settings.model)

    def find(identity: Identity) -> RobotModel:
        if named is not None:
            return named
        subtype = identity.subtype.lower()
        known = configs.names("robots")
        if subtype not in known:
            near = configs.nearest("robots", subtype, 0.0)
            full = ", ".join(configs.described("robots", each) for each in near)
            raise GatewayError(
                f"the robot {identity.name!r} is a {identity.subtype!r}, which is no known model; nearest are "
                f"{full}: name one in a file for --config, as in model = {near[0]!r}",
                ExitCode.UNKNOWN_MODEL,
            )
        return configs.load(RobotModel, "robots", subtype)

    return find


class Search:
    """Judges the driver's events until a robot has been found.

    found: the handshake, once there was one.
    """

    def __init__(self, port_name: str, now: float) -> None:
        self._port_name = port_name
        self._since = now
        self._sweeps = 0
        self.found: HandshakeCompleted | None = None

    def take(self, events: Sequence[Event], problem: LinkProblem | None, now: float) -> None:
        """Take the driver's events.

        Args:
            events: In their order.
            problem: Why no robot is connected, as the driver has it.
            now: Steady time, s.
        Raises:
            GatewayError: There is no robot here that could be served.
        """
        for event in events:
            match event:
                case HandshakeCompleted():
                    self.found = event
                case RobotRejected(error):
                    raise error
                case SweepFailed():
                    self._sweeps += 1
        if self.found is not None or problem is None or now - self._since < PATIENCE:
            return
        if self._sweeps >= SWEEPS or problem.cause in NO_SWEEPS:
            code = FAILURES.get(problem.cause, ExitCode.NOT_A_ROBOT)
            raise GatewayError(f"{self._port_name}: {problem.sentence}", code)

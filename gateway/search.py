"""Looking for a robot on a port: which rates, which model, and what to tell a person when there is none."""

import difflib
import re
from collections.abc import Sequence

import configs
from gateway.connector import AS_IT_IS, RATES
from gateway.driver import ModelFinder
from gateway.errors import GatewayError, NotARobot, RobotSilent, UnknownModel
from gateway.events import Event, HandshakeCompleted, RobotRejected, SweepFailed
from gateway.serial_port import Port
from gateway.settings import Settings
from p2os import Identity, RobotModel

PATIENCE = 2.5
"""Seconds to look for a robot, at the least."""
SWEEPS = 2
"""Times to try every rate, at the least."""
NOT_IN_A_KEY = re.compile(r"[^\w.+-]", re.ASCII)


def rates_to_try(port: Port, baud: int | None) -> tuple[int, ...]:
    """The rates at which to look for the robot, bit/s.

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
    """Models from `configs/robots`, or the one that the settings name.

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
            near = difflib.get_close_matches(subtype, known, 3, 0.0)
            raise UnknownModel(
                f"the robot {identity.name!r} is a {identity.subtype!r}, which is no known model; nearest are "
                f"{', '.join(near)}: name one in a file for --config, as in model = {near[0]!r}"
            )
        return configs.load(RobotModel, "robots", subtype)

    return find


def bus_name(identity: Identity) -> str:
    """The name that a robot gives itself, made one chunk of a key."""
    return NOT_IN_A_KEY.sub("_", identity.name) or NOT_IN_A_KEY.sub("_", identity.subtype) or "robot"


class Search:
    """Judges the driver's events until a robot has been found.

    found: the handshake, once there was one.
    """

    def __init__(self, port_name: str, now: float) -> None:
        self._port_name = port_name
        self._since = now
        self._sweeps = 0
        self._bytes_heard = 0
        self.found: HandshakeCompleted | None = None

    def take(self, events: Sequence[Event], now: float) -> None:
        """Take the driver's events.

        Raises:
            GatewayError: There is no robot here: RobotSilent, NotARobot, UnknownModel.
        """
        for event in events:
            match event:
                case HandshakeCompleted():
                    self.found = event
                case RobotRejected(error):
                    raise error
                case SweepFailed(rates, bytes_heard) if self.found is None:
                    self._sweeps += 1
                    self._bytes_heard += bytes_heard
                    if self._sweeps >= SWEEPS and now - self._since >= PATIENCE:
                        raise self._failure(rates)

    def _failure(self, rates: Sequence[int]) -> GatewayError:
        at = "" if rates == (AS_IT_IS,) else f" at {', '.join(map(str, rates))} bit/s"
        if self._bytes_heard:
            return NotARobot(
                f"something answers on {self._port_name}, but not as a P2OS robot does: {self._bytes_heard} bytes{at} "
                "and no handshake; check which cable this is"
            )
        return RobotSilent(
            f"no robot answers on {self._port_name}{at}; switch it on, check the cable, and see that its own computer "
            "is off"
        )

"""A gateway at work: looks for the robot, opens the bus meanwhile, joins the two, and says how it goes."""

import gc
import json
import sys
import threading
from collections.abc import Sequence
from dataclasses import dataclass
from math import inf
from typing import TYPE_CHECKING, Any

from gateway.bridge import Bridge
from gateway.cables.cable import ElementThread
from gateway.driver import Driver
from gateway.element_news import ElementNews
from gateway.errors import NameInUse, RobotNameNotValid
from gateway.events import Event, HandshakeCompleted, LinkLost
from gateway.link_diagnosis import LinkProblem, LinkReports
from gateway.search import Search, bus_name
from gateway.settings import Settings

if TYPE_CHECKING:
    from bus import Bus
    from bus.name_holder import BusProgram
    from gateway.robot_on_bus import RobotOnBus

BUS_PERIOD = 1.0
"""Seconds between two tries to open the bus."""
SECOND_LOOK = 1.0
"""Seconds after the robot has come to the bus; others that came at the same moment are seen by then."""


@dataclass(frozen=True, slots=True)
class GatewayOptions:
    """What the command line says beyond the settings.

    name: on the bus; None for the name that the robot gives itself. bus: profile or file. waits: look for a robot
    forever. forces: wait until another gateway of this name has ended, and take over then. is_quiet: say nothing but
    errors. is_json: say it in JSON, a line each.
    """

    port: str
    name: str | None = None
    bus: str = "local"
    waits: bool = False
    forces: bool = False
    is_quiet: bool = False
    is_json: bool = False


def tell(options: GatewayOptions, sentence: str, facts: dict[str, Any]) -> None:
    """Say what happens, as a sentence or as JSON."""
    if options.is_json:
        print(json.dumps({**facts, "port": options.port}), flush=True)
    elif not options.is_quiet:
        print(sentence, flush=True)


def tell_problem(options: GatewayOptions, problem: LinkProblem | None) -> None:
    """Print why there is no robot, if that is to be printed: on standard error, or as JSON on standard output."""
    if problem is None:
        return
    if options.is_json:
        tell(options, "", {"event": "no robot", "cause": problem.cause.value, "reason": problem.sentence})
    else:
        at = "" if options.port in problem.sentence else f"{options.port}: "
        print(f"p2os-gateway: {at}{problem.sentence}", file=sys.stderr, flush=True)


class Gateway:
    """Hears the bridge, and brings the robot to the bus as soon as both are there.

    The bus is opened, and the robot brought to it, on a thread of its own: that takes longer than the handshake, and
    would keep the bridge's thread so long that the driver takes it for a freeze.
    """

    def __init__(
        self,
        options: GatewayOptions,
        settings: Settings,
        driver: Driver,
        bridge: Bridge[Driver],
        now: float,
        cables: Sequence[ElementThread] = (),
    ) -> None:
        self._options = options
        self._settings = settings
        self._driver = driver
        self._bridge = bridge
        self._cables = cables
        self._element_news = ElementNews(cables)
        self._search = Search(options.port, now)
        self._link_reports = LinkReports()
        self._kept: dict[type[Event], tuple[Event, int]] = {}  # the latest of each kind, with its stamp
        self._complaint = ""
        self._bus: Bus | None = None
        self._bus_error: Exception | None = None
        self._joined: RobotOnBus | None = None
        self._robot: RobotOnBus | None = None
        self._is_known = threading.Event()  # who the robot is; or all is over, and it does not matter
        self._is_closed = threading.Event()
        self._opener = threading.Thread(target=self._open_bus, name="bus opener", daemon=True)
        self._opener.start()

    @property
    def deadline(self) -> float:
        """When `on_events` is due even without events, s."""
        return inf if self._robot is None else self._robot.deadline

    def on_events(self, events: Sequence[Event], now: float, stamp_ns: int) -> None:
        """Take the driver's events.

        Raises:
            GatewayError: There is no robot that could be served, and there was none before; or the name is no key.
            ConfigError: The bus profile is of no use.
        """
        if self._bus_error is not None:
            raise self._bus_error
        if self._search.found is None and not self._options.waits:
            self._search.take(events, self._driver.link_problem, now)
        for event in events:
            self._say(event)
        if self._options.waits or self._search.found is not None:
            tell_problem(self._options, self._link_reports.due(self._driver.link_problem, now))
        if self._robot is None:
            self._keep(events, stamp_ns)
            if self._driver.identity is not None:
                self._is_known.set()
            if self._joined is None:
                return
            self._robot = self._joined
            self._robot.publish_kept(self._kept.values())
            events, self._kept = [], {}
        self._robot.on_events(events, now, stamp_ns)
        self._say_elements(now)

    def close(self) -> None:
        """Let go of the cables and leave the bus."""
        for cable in self._cables:
            cable.close()
        self._is_closed.set()
        self._is_known.set()
        self._opener.join()
        if self._joined is not None:
            self._joined.close()
        if self._bus is not None:
            self._bus.close()

    def _keep(self, events: Sequence[Event], stamp_ns: int) -> None:
        """Keep what is to be published once the robot is on the bus: nothing that a later event supersedes."""
        for event in events:
            if isinstance(event, LinkLost):
                self._kept.clear()
            else:
                self._kept.pop(type(event), None)  # so that the order is that of the events
                self._kept[type(event)] = event, stamp_ns

    def _open_bus(self) -> None:
        try:
            # Here and not at the top: loading them takes longer than the whole handshake.
            import gateway.robot_on_bus  # noqa: F401 - used once there is a robot, and then without delay
            from bus import BusUnavailable, KeyNotValid, ZenohBus
            from bus.keys import robot_name
            from bus.name_holder import BusProgram

            gc.freeze()  # what was loaded stays to the end: no need to look through it, then least of all
            try:
                robot_name(self._options.name or "robot")
            except KeyNotValid as error:
                raise RobotNameNotValid(str(error)) from error
            while self._bus is None and not self._is_closed.is_set():
                try:
                    self._bus = ZenohBus.open(self._options.bus)
                except BusUnavailable as error:
                    self._complain(f"{error}; trying again")
                    self._is_closed.wait(BUS_PERIOD)
            self._is_known.wait()
            if self._bus is not None and not self._is_closed.is_set():
                own = BusProgram.here()
                self._await_name(self._bus)
                if not self._is_closed.is_set():
                    self._joined = self._join_robot(self._bus, own)
                    self._bridge.wake()
                    if not self._is_closed.wait(SECOND_LOOK):  # two that started together have found the name free
                        self._check_name(self._bus, own)
        except Exception as error:  # of any kind: the bridge's thread raises it, and the program ends
            self._bus_error = error
        self._bridge.wake()

    def _await_name(self, bus: "Bus") -> None:
        """See that no other gateway has the robot's name; wait until it is free if that was asked for.

        Raises:
            NameInUse: Another one has it.
        """
        while not self._is_closed.is_set():
            try:
                self._check_name(bus)
                return
            except NameInUse as error:
                if not self._options.forces:
                    raise
                self._complain(f"{error.holder}; waiting until it has ended")
                self._is_closed.wait(BUS_PERIOD)

    def _check_name(self, bus: "Bus", own: "BusProgram | None" = None) -> None:
        """See that no other gateway has the robot's name. own: this one, once it has taken the name too.

        Raises:
            NameInUse: Another one has it; if both have taken it, an earlier one.
        """
        from bus import NameTaken
        from bus.keys import DESCRIPTION
        from bus.name_holder import check_name_free

        try:
            check_name_free(bus, self._name, DESCRIPTION.key(self._name), own)
        except NameTaken as error:
            raise NameInUse(str(error)) from error

    def _join_robot(self, bus: "Bus", process: "BusProgram") -> "RobotOnBus":
        """Bring the robot to the bus, and the elements on cables of their own with it."""
        from bus import NotAllowed
        from gateway.robot_on_bus import RobotOnBus

        try:
            return RobotOnBus(
                self._name, bus, self._driver, self._bridge, self._settings, cables=self._cables, process=process
            )
        except NotAllowed as error:
            raise RobotNameNotValid(f"the robot cannot be {self._name} on this bus: {error}") from error

    @property
    def _name(self) -> str:
        assert self._driver.identity is not None  # asked for only once the robot is known
        return self._options.name or bus_name(self._driver.identity)

    def _say(self, event: Event) -> None:
        match event:
            case HandshakeCompleted(identity, model, baud):
                at = f" at {baud} bit/s" if baud else ""
                self._tell(
                    f"connected to {identity.name} ({model.name}){at}; keys under {self._name}/",
                    {"event": "connected", "robot": self._name, "model": model.name, "baud": baud or None},
                )
            case LinkLost(reason):
                self._tell(f"lost: {reason}; looking for the robot", {"event": "lost", "reason": reason})

    def _say_elements(self, now: float) -> None:
        """What has become of the elements on cables of their own."""
        for element, answers, has_been, reasons in self._element_news.since(now):
            if answers:
                self._tell(f"the {element} answers", {"event": "element found", "element": element})
            elif has_been:
                self._tell(f"lost the {element}; looking for it", {"event": "element lost", "element": element})
            else:
                self._complain(f"{'; '.join(reasons)}; looking for it")

    def _tell(self, sentence: str, facts: dict[str, Any]) -> None:
        tell(self._options, sentence, facts)

    def _complain(self, sentence: str) -> None:
        """Say it once, however often it goes on being so."""
        if sentence == self._complaint:
            return
        self._complaint = sentence
        print(f"p2os-gateway: {sentence}", file=sys.stderr, flush=True)

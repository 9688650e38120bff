"""Searches for one robot, brings it to the bus of the process, and prints what happens."""

import json
import re
import sys
import threading
import time
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from importlib import import_module
from math import inf
from typing import TYPE_CHECKING, Any, TextIO

from configs.startup import uncollected
from gateway.bridge import Bridge
from gateway.cables.cable import ElementThread
from gateway.driver import Driver
from gateway.errors import ExitCode, GatewayError, NameInUse
from gateway.events import Event, HandshakeCompleted, LinkLost
from gateway.link_diagnosis import ElementReports, LinkProblem, LinkReports
from gateway.search import Search
from gateway.settings import Settings
from p2os import Identity

if TYPE_CHECKING:
    from bus import Bus
    from bus.name_holder import BusProgram
    from gateway.robot_on_bus import RobotOnBus

BUS_PERIOD = 1.0
"""Seconds between two tries to open the bus."""
FIRST_LOOK = 0.06
"""Seconds in which another gateway of this name answers, as a rule: measured, 1 to 5 ms after a session is open, and up
to 50 ms where four programs want each core."""
_NOT_IN_A_KEY = re.compile(r"[^\w.+-]", re.ASCII)
LATER_LOOKS = (0.25, 0.5, 1.0, 2.5)
"""Seconds after the robot has come to the bus; others that came at the same moment, and those that the bus has found
late, are seen by then."""


@dataclass(frozen=True, slots=True)
class GatewayOptions:
    """Options of the command line beyond the settings, and what is printed by them.

    name: on the bus; None for the name that the robot gives itself. bus: profile or file. waits: look for a robot
    forever. forces: wait until another gateway of this name has ended, and take over then. is_quiet: print errors
    only. is_json: print events as JSON, one line each. is_one_of_many: the process serves other robots as well, so
    sentences begin with the port.
    """

    port: str
    name: str | None = None
    bus: str = "local"
    waits: bool = False
    forces: bool = False
    is_quiet: bool = False
    is_json: bool = False
    is_one_of_many: bool = False

    def report_event(self, sentence: str, facts: dict[str, Any]) -> None:
        """Print an event, as a sentence or as JSON."""
        if self.is_json:
            robot = {} if self.name is None else {"robot": self.name}
            _print(json.dumps({**robot, **facts, "port": self.port}), sys.stdout)
        elif not self.is_quiet:
            _print(f"{self.port}: {sentence}" if self.is_one_of_many else sentence, sys.stdout)

    def report_error(self, sentence: str) -> None:
        """Print an error on standard error; it begins with the port where several robots are served."""
        at = f"{self.port}: " if self.is_one_of_many and not sentence.startswith(self.port) else ""
        _print(f"p2os-gateway: {at}{sentence}", sys.stderr)

    def report_problem(self, problem: LinkProblem | None) -> None:
        """Print why there is no robot, if that is to be printed: on standard error, or as JSON on standard output."""
        if problem is None:
            return
        if self.is_json:
            self.report_event("", {"event": "no robot", "cause": problem.cause.value, "reason": problem.sentence})
        else:
            at = "" if self.port in problem.sentence else f"{self.port}: "
            _print(f"p2os-gateway: {at}{problem.sentence}", sys.stderr)


def _print(line: str, file: TextIO) -> None:
    """Print a line in one call, so that lines of several robots do not mix."""
    with suppress(OSError, ValueError):  # nobody reads it any more, or it is closed; the robots are served all the same
        print(f"{line}\n", end="", file=file, flush=True)


class SharedBus:
    """The bus session of this process, on which all its robots are; opened when the first one needs it."""

    def __init__(self, profile: str) -> None:
        self._profile = profile
        self._bus: Bus | None = None
        self._opening = threading.Lock()

    def open(self) -> "Bus":
        """Return the session; open it first if it is not open.

        Raises:
            BusUnavailable: It cannot be opened now.
            ConfigError: The profile cannot be used.
        """
        with self._opening:
            if self._bus is None:
                with uncollected():
                    # Here and not at the top: loading them takes longer than the whole handshake.
                    from bus import ZenohBus

                    import_module("gateway.robot_on_bus")  # used once there is a robot, and then without delay

                self._bus = ZenohBus.open(self._profile)
            return self._bus

    def close(self) -> None:
        """Leave the bus."""
        with self._opening:
            if self._bus is not None:
                self._bus.close()


class Gateway:
    """Receives the bridge's events, and brings the robot to the bus as soon as both are there.

    The bus is opened, and the robot brought to it, on a thread of its own: that takes longer than the handshake, and
    would keep the bridge's thread so long that the driver takes it for a freeze.
    """

    def __init__(
        self,
        options: GatewayOptions,
        settings: Settings,
        driver: Driver,
        bridge: Bridge[Driver],
        bus: SharedBus,
        now: float,
        cables: Sequence[ElementThread] = (),
    ) -> None:
        self._options = options
        self._settings = settings
        self._driver = driver
        self._bridge = bridge
        self._cables = cables
        self._element_reports = ElementReports(cables)
        self._search = Search(options.port, now)
        self._link_reports = LinkReports()
        self._kept: dict[type[Event], tuple[Event, int]] = {}  # the latest of each kind, with its stamp
        self._last_error = ""
        self._bus = bus
        self._bus_error: Exception | None = None
        self._joined: RobotOnBus | None = None
        self._robot: RobotOnBus | None = None
        self._is_known = threading.Event()  # the robot is known, or the gateway is closing
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
            self._report_link(event)
        if self._options.waits or self._search.found is not None:
            self._options.report_problem(self._link_reports.due(self._driver.link_problem, now))
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
        self._report_elements(now)

    def close(self) -> None:
        """Let go of the cables, and take the robot from the bus."""
        for cable in self._cables:
            cable.close()
        self._is_closed.set()
        self._is_known.set()
        self._opener.join()
        if self._joined is not None:
            self._joined.close()

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
            bus = self._await_bus()
            self._is_known.wait()
            if bus is None or self._is_closed.is_set():
                return
            from bus.name_holder import BusProgram

            own = BusProgram.here()
            if not self._seems_free(bus):
                self._await_name(bus)
            if not self._is_closed.is_set():
                self._joined = self._join_robot(bus, own)
                self._bridge.wake()
                joined_at = time.monotonic()
                for look in LATER_LOOKS:
                    if self._is_closed.wait(joined_at + look - time.monotonic()):
                        break
                    self._check_name(bus, own)
        except Exception as error:  # of any kind: the bridge's thread raises it, and the robot is not served any more
            self._bus_error = error
        finally:
            self._bridge.wake()

    def _await_bus(self) -> "Bus | None":
        """Return the bus once it is open, and the messages of a robot prepared; None while the gateway closes."""
        while not self._is_closed.is_set():
            from bus import BusUnavailable, KeyNotValid
            from bus.keys import robot_name

            try:
                robot_name(self._options.name or "robot")
                return self._bus.open()
            except KeyNotValid as error:
                raise GatewayError(str(error), ExitCode.USAGE) from error
            except BusUnavailable as error:
                self._report_error(f"{error}; trying again")
                self._is_closed.wait(BUS_PERIOD)
        return None

    def _seems_free(self, bus: "Bus") -> bool:
        """Return whether no other gateway answers to the robot's name within `FIRST_LOOK`; prepare messages meanwhile.

        It is looked for again in `LATER_LOOKS`, since a session that has just been opened may not know all others.
        """
        from bus import NoAnswer
        from bus.keys import DESCRIPTION
        from bus.messages import prepare
        from gateway.streams import STREAMS

        errors: list[Exception | None] = []
        has_ended = threading.Event()

        def on_end(error: Exception | None) -> None:
            errors.append(error)
            has_ended.set()

        with bus.ask(DESCRIPTION.key(self._name), None, lambda answer: None, on_end, FIRST_LOOK):
            for topic in STREAMS:
                prepare(topic.type_name)
            has_ended.wait(2.0 * FIRST_LOOK)
        return [type(error) for error in errors] == [NoAnswer]  # and not TimedOut: one that is known may be busy

    def _await_name(self, bus: "Bus") -> None:
        """Check that no other gateway has the robot's name; wait until it is free if the options say so.

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
                self._report_error(f"{error.holder}; waiting until it has ended")
                self._is_closed.wait(BUS_PERIOD)

    def _check_name(self, bus: "Bus", own: "BusProgram | None" = None) -> None:
        """Check that no other gateway has the robot's name. own: this one, once it has taken the name too.

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
            why = f"the robot cannot be {self._name} on this bus: {error}"
            raise GatewayError(why, ExitCode.USAGE) from error

    @property
    def _name(self) -> str:
        assert self._driver.identity is not None  # asked for only once the robot is known
        return self._options.name or _bus_name(self._driver.identity)

    def _report_link(self, event: Event) -> None:
        match event:
            case HandshakeCompleted(identity, model, baud):
                at = f" at {baud} bit/s" if baud else ""
                self._report(
                    f"connected to {identity.name} ({model.name}){at}; keys under {self._name}/",
                    {"event": "connected", "robot": self._name, "model": model.name, "baud": baud or None},
                )
            case LinkLost(reason):
                self._report(f"lost: {reason}; looking for the robot", {"event": "lost", "reason": reason})

    def _report_elements(self, now: float) -> None:
        """Print which elements on cables of their own were found or lost."""
        for element, answers, has_answered, reasons in self._element_reports.due(now):
            if answers:
                self._report(f"the {element} answers", {"event": "element found", "element": element})
            elif has_answered:
                self._report(f"lost the {element}; looking for it", {"event": "element lost", "element": element})
            else:
                self._report_error(f"{'; '.join(reasons)}; looking for it")

    def _report(self, sentence: str, facts: dict[str, Any]) -> None:
        self._options.report_event(sentence, facts)

    def _report_error(self, sentence: str) -> None:
        """Print an error once, until another one occurs."""
        if sentence == self._last_error:
            return
        self._last_error = sentence
        self._options.report_error(sentence)


def _bus_name(identity: Identity) -> str:
    """Return the robot's own name, as one chunk of a key."""
    return _NOT_IN_A_KEY.sub("_", identity.name) or _NOT_IN_A_KEY.sub("_", identity.subtype) or "robot"

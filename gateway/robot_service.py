"""Serves the robots of one `p2os-gateway`: each on a thread of its own, all on one bus session.

The robots share nothing but the bus session. Each has a port, a driver, a lock and a thread, so a port that hangs, or
an error in the code that serves one robot, concerns that robot only.
"""

import logging
import queue
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from types import FrameType

from configs import ConfigError
from gateway.bridge import BRAKING_TIME, REOPEN_PERIOD, Bridge, steady_clock
from gateway.cables.cable_thread import CableKind
from gateway.connector import RATES
from gateway.driver import Driver
from gateway.errors import GatewayError, NoSuchPort
from gateway.gateway import Gateway, GatewayOptions, SharedBus
from gateway.line import RADIO_BAUD
from gateway.link_diagnosis import LinkDiagnosis, LinkReports
from gateway.search import model_finder, rates_to_try
from gateway.serial_port import Port, open_port
from gateway.settings import Settings

RESTART_PERIOD = 1.0
"""Seconds until a robot is served again after an unexpected error, in a process that serves others."""
ENDING_TIMEOUT = 2.0 * BRAKING_TIME + 1.0
"""Seconds for all robots and their elements to stop at the end."""
OPENING_TIMEOUT = 0.5
"""Seconds at the end for robots whose port is not open yet: they have nothing to stop, and may hang in opening it."""
LOOK_PERIOD = 1.0
"""Seconds of one sleep of the main thread: a signal that arrives just before one is noticed after it."""

log = logging.getLogger("gateway")


@dataclass(frozen=True, slots=True)
class RobotPlan:
    """What the command line and the settings file of one robot say.

    baud: the only rate to try, bit/s; None tries all. cables: how elements on cables of their own are opened, with
    their addresses.
    """

    options: GatewayOptions
    settings: Settings
    baud: int | None = None
    cables: Sequence[tuple[CableKind, str]] = ()


class _RobotService:
    """Serves one robot from opening its port until `stop`.

    plan: of this robot. has_port: the port was opened, so the robot must be stopped at the end.
    """

    def __init__(self, plan: RobotPlan, bus: SharedBus) -> None:
        self.plan = plan
        self.has_port = False
        self._bus = bus
        self._bridge: Bridge[Driver] | None = None
        self._is_stopped = threading.Event()

    def run(self) -> None:
        """Serve the robot; return after `stop`.

        Raises:
            GatewayError: The port cannot be opened, no robot that could be served is there, or its name is in use.
            ConfigError: The settings or the bus profile cannot be used.
        """
        plan = self.plan
        options, settings = plan.options, plan.settings
        find_model = model_finder(settings)
        port = self._open_first()
        if port is None:
            return
        # On leaving, in this order and each even if one fails: stop the elements, stop the robot, leave the bus.
        with ExitStack() as leaving:
            leaving.callback(port.close)
            cables = []
            for kind, address in plan.cables:
                cables.append(kind.open(address, settings, options.waits))
                leaving.callback(cables[-1].close)
            rates = rates_to_try(port, RADIO_BAUD if settings.radio else plan.baud)
            driver = Driver(find_model, rates, settings, probe_rates=_rates_to_probe(port, settings, rates))
            bridge = Bridge(driver, port, lambda: open_port(options.port))
            gateway = Gateway(options, settings, driver, bridge, self._bus, steady_clock(), cables)
            leaving.callback(gateway.close)
            leaving.callback(bridge.close)
            for cable in cables:
                leaving.callback(cable.halt)
            self._bridge, self.has_port = bridge, True
            if self._is_stopped.is_set():
                return
            for cable in cables:
                cable.start()
            bridge.run(gateway)

    def stop(self) -> None:
        """Let `run` return; from any thread or signal handler."""
        self._is_stopped.set()
        if self._bridge is not None:
            self._bridge.stop()

    def wait_for_stop(self, seconds: float) -> bool:
        """Wait; return whether `stop` was called meanwhile."""
        return self._is_stopped.wait(seconds)

    def _open_first(self) -> Port | None:
        """Open the port; wait for it only if asked to. None after `stop`."""
        options = self.plan.options
        is_told = False
        diagnosis, reports = LinkDiagnosis(), LinkReports()
        while not self._is_stopped.is_set():
            try:
                return open_port(options.port)
            except NoSuchPort as error:
                if not options.waits:
                    raise
                diagnosis.begin(steady_clock())
                diagnosis.note_no_port(str(error))
            if not is_told:
                options.report_event(f"waiting for {options.port}", {"event": "waiting"})
                is_told = True
            options.report_problem(reports.due(diagnosis.problem(steady_clock()), steady_clock()))
            self._is_stopped.wait(REOPEN_PERIOD)
        return None


def serve_robots(plans: Sequence[RobotPlan], on_failure: Callable[[RobotPlan, Exception], None]) -> None:
    """Serve robots until SIGINT or SIGTERM, or until none is left.

    Of several robots one that cannot be served any more leaves the others alone. After an unexpected error, one of
    several is served again; a single one ends the process, so that a supervisor can start it again.

    Args:
        plans: One for each robot; all have the same bus profile.
        on_failure: Called, on this thread, with each robot that cannot be served any more.
    """
    bus = SharedBus(plans[0].options.bus)
    services = [_RobotService(plan, bus) for plan in plans]
    ended: queue.SimpleQueue[tuple[_RobotService, Exception | None] | None] = queue.SimpleQueue()
    is_ending = False

    def stop(number: int, frame: FrameType | None) -> None:
        nonlocal is_ending
        is_ending = True
        for service in services:
            service.stop()
        ended.put(None)

    def run(service: _RobotService) -> None:
        error = _run(service, restarts=len(services) > 1)
        ended.put((service, error))

    with _signals(stop):
        try:
            for service in services:
                name = f"robot {service.plan.options.port}"
                threading.Thread(target=run, args=(service,), name=name, daemon=True).start()
            running = set(services)
            while running:
                may_take = ENDING_TIMEOUT if any(service.has_port for service in running) else OPENING_TIMEOUT
                try:
                    end = ended.get(timeout=may_take if is_ending else LOOK_PERIOD)
                except queue.Empty:
                    if is_ending:
                        break  # the remaining ports hang; their robots stop by their watchdogs
                    continue
                if end is not None:
                    service, error = end
                    running.discard(service)
                    if error is not None:
                        on_failure(service.plan, error)
        finally:
            bus.close()


def _run(service: _RobotService, restarts: bool) -> Exception | None:
    """Serve a robot; return why it cannot be served any more. restarts: serve it again after an unexpected error."""
    while True:
        try:
            service.run()
            return None
        except (GatewayError, ConfigError) as error:
            return error
        except Exception as error:  # of any kind: it must not end the service of other robots
            if not restarts:
                return error
            log.exception("%s: an unexpected error; the robot is served again", service.plan.options.port)
        if service.wait_for_stop(RESTART_PERIOD):
            return None


def _rates_to_probe(port: Port, settings: Settings, rates: Sequence[int]) -> tuple[int, ...]:
    """Return further rates, bit/s, at which to probe for a robot; none behind a radio modem."""
    if port.rate is None or settings.radio:
        return ()
    return tuple(rate for rate in RATES if rate not in rates)


@contextmanager
def _signals(handler: Callable[[int, FrameType | None], object]) -> Iterator[None]:
    """Let SIGINT and SIGTERM call this handler meanwhile."""
    before = {number: signal.signal(number, handler) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for number, earlier in before.items():
            signal.signal(number, earlier)

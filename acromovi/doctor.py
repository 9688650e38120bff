"""`acromovi doctor [PORT]`: check the connection to a robot step by step, and advise what to do.

It moves nothing: the robot hears STOP and CLOSE first, motors and sonar are left alone, and CLOSE comes last.
"""

import argparse
import importlib
import json
import sys
from collections.abc import Callable, Iterator, Sequence
from importlib.metadata import PackageNotFoundError, version
from typing import NamedTuple

from acromovi.options import add_bus
from acromovi.subcommand import Subcommand
from configs import ConfigError
from configs.extras import EXTRAS, install_command, missing
from gateway.bridge import Bridge, steady_clock
from gateway.driver import Driver
from gateway.errors import GatewayError, PortBusy
from gateway.events import Event, HandshakeCompleted, SipReceived
from gateway.local_ports import candidates, holders
from gateway.search import Search, model_finder, rates_to_try
from gateway.serial_port import open_port
from gateway.settings import Settings
from p2os import StandardSip

EPILOG = """\
examples:
  acromovi doctor
  acromovi doctor /dev/ttyUSB0 --json

An extra that is not installed is marked NOTE: only the commands that it is needed for do not work.

Exit codes: 0 everything is in order, 1 something is not, 2 wrong usage, 130 stopped by Ctrl-C.
"""
OLDEST, NEWEST = (3, 11), (3, 13)
PACKAGES = {"zenoh": "eclipse-zenoh", "serial": "pyserial", "rosbags": "rosbags", "numpy": "numpy"}
"""Module to distribution."""
PORT_PATIENCE = 10.0
"""Seconds for everything; a port that comes and goes could keep us forever."""
QUIET_SETTINGS = Settings(enable_motors=False, sonar=None, inputs_outputs=False)
SIPS_TO_HEAR = 3
SIP_PATIENCE = 2.0
"""Seconds to wait for so many information packets once the robot has said who it is."""


class _Finding(NamedTuple):
    """One step. advice: what to do where it is not OK, or where it is and something optional is missing."""

    check: str
    is_ok: bool
    found: str
    advice: str = ""

    @property
    def label(self) -> str:
        """Return OK, FAIL, or NOTE for an optional part that is missing."""
        if not self.is_ok:
            return "FAIL"
        return "NOTE" if self.advice else "OK"


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "port", nargs="?", metavar="PORT", help="port of the robot; without it only this computer is checked"
    )
    add_bus(parser)
    parser.add_argument("--json", action="store_true", help="print one JSON object a line")


def _run(arguments: argparse.Namespace) -> int:
    """Print a line for each step; returns 0 if all are OK, 1 otherwise."""
    all_ok = True
    for finding in examine(arguments.port, arguments.bus):
        all_ok &= finding.is_ok
        if arguments.json:
            print(json.dumps(finding._asdict()), flush=True)
        else:
            advice = f": {finding.advice}" if finding.advice else ""
            print(f"{finding.label:4} {finding.check}: {finding.found}{advice}", flush=True)
    return 0 if all_ok else 1


def examine(port: str | None, bus_profile: str) -> Iterator[_Finding]:
    """Run the checks in order; those of the robot end with the first that is not OK."""
    yield _python()
    yield from map(_package, PACKAGES)
    yield from map(_extra, EXTRAS)
    yield _bus(bus_profile)
    if port is not None:
        yield from _robot(port)
    else:
        yield _Finding("ports", True, _ports_here())


def _python() -> _Finding:
    here = sys.version_info[:2]
    found = ".".join(map(str, sys.version_info[:3]))
    advice = "" if OLDEST <= here <= NEWEST else "install Python 3.11, 3.12 or 3.13"
    return _Finding("Python", not advice, found, advice)


def _package(module: str) -> _Finding:
    distribution = PACKAGES[module]
    try:
        importlib.import_module(module)
        return _Finding(distribution, True, version(distribution))
    except (ImportError, PackageNotFoundError) as error:
        return _Finding(distribution, False, str(error), f"pip install {distribution}")


def _extra(extra: str) -> _Finding:
    """Report whether an extra is installed. A missing one is no failure, since most commands do not need it."""
    if not missing(extra):
        return _Finding(f"extra {extra}", True, "installed")
    found = f"not installed, needed for {EXTRAS[extra].purpose}"
    return _Finding(f"extra {extra}", True, found, f"install with {install_command(extra)}")


def _bus(profile: str) -> _Finding:
    from bus import BusUnavailable, ZenohBus  # not at the top: it may be what is missing
    from bus.secure import Profile

    try:
        ZenohBus.open(profile).close()
    except (BusUnavailable, ConfigError) as error:
        return _Finding("bus", False, str(error), "see the profiles in configs/bus")
    if (local := Profile.find(profile).local) is None:
        return _Finding("bus", True, f"profile {profile} opens")
    group, port = local.scouting_address
    where = f"{len(local.entries())} programs are on it, plain Zenoh programs join it at {group}:{port}"
    return _Finding("bus", True, f"profile {profile} opens; {where}")


def _ports_here() -> str:
    here = candidates()
    return f"ports of this computer: {', '.join(here)}" if here else "this computer has no port that may be a robot's"


def _robot(name: str) -> Iterator[_Finding]:
    try:
        port = open_port(name)
    except PortBusy as error:
        held = " and ".join(map(str, holders(name)))
        yield _Finding("port", False, str(error), f"it is held by {held or 'a program of another user'}")
        return
    except GatewayError as error:
        yield _Finding("port", False, str(error), _ports_here())
        return
    yield _Finding("port", True, f"{name} is there and free")
    driver = Driver(model_finder(QUIET_SETTINGS), rates_to_try(port, None), QUIET_SETTINGS)
    bridge = Bridge(driver, port, lambda: open_port(name))
    visit = _RobotProbe(name, driver, bridge.stop)
    try:
        bridge.run(visit)
        yield from visit.findings()
    except GatewayError as error:
        yield _Finding("robot", False, str(error))
    finally:
        bridge.close()


class _RobotProbe:
    """Listens to a robot until enough is known."""

    def __init__(self, port: str, driver: Driver, leave: Callable[[], None]) -> None:
        self._search = Search(port, steady_clock())
        self._driver = driver
        self._leave = leave
        self._sips: list[StandardSip] = []
        self.deadline = steady_clock() + PORT_PATIENCE

    def on_events(self, events: Sequence[Event], now: float, stamp_ns: int) -> None:
        """Take the driver's events; raises GatewayError when there is no robot."""
        self._search.take(events, self._driver.link_problem, now)
        self._sips += [event.sip for event in events if isinstance(event, SipReceived)]
        if any(isinstance(event, HandshakeCompleted) for event in events):
            self.deadline = now + SIP_PATIENCE
        if len(self._sips) >= SIPS_TO_HEAR or now >= self.deadline:
            self._leave()

    def findings(self) -> Iterator[_Finding]:
        """Return the findings."""
        found = self._search.found
        if found is None:
            problem = self._driver.link_problem
            found_instead = problem.sentence if problem else "the port went away while we were looking"
            yield _Finding("robot", False, found_instead, "" if problem else "check the plug and the cable")
            return
        name, _, subtype = found.identity
        at = f" at {found.baud} bit/s" if found.baud else ""
        yield _Finding("robot", True, f"{name} answers{at}")
        yield _Finding("model", True, f"{subtype}, known as {found.model.name}")
        if not self._sips:
            yield _Finding("packets", False, "no information packet came", "switch the robot off and on, and try again")
            return
        yield _Finding("packets", True, f"{len(self._sips)} information packets read")
        voltage, nominal = self._sips[-1].best_battery, found.model.battery_nominal
        low = found.model.flash.low_battery * nominal
        advice = "" if voltage >= low else f"charge it; {low:.1f} V is low for this robot"
        yield _Finding("battery", not advice, f"{voltage:.1f} V of {nominal:.0f} V", advice)


COMMAND = Subcommand(EPILOG, _add_arguments, _run)

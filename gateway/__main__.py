"""The command `p2os-gateway`: brings a robot on a serial port to the bus."""

import argparse
import signal
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path
from types import FrameType
from typing import NoReturn

from configs import ConfigError
from configs.command_line import CommandParser
from configs.defaults import VARIABLE, default_bus
from gateway.bridge import REOPEN_PERIOD, Bridge, steady_clock
from gateway.cables.cable_thread import CableKind
from gateway.driver import Driver
from gateway.elements.all_elements import cable_kinds
from gateway.errors import GatewayError, NoSuchPort, PortBusy
from gateway.gateway import Gateway, GatewayOptions, report_event, report_problem
from gateway.line import RADIO_BAUD
from gateway.link_diagnosis import LinkDiagnosis, LinkReports
from gateway.local_ports import holders
from gateway.search import model_finder, rates_to_probe, rates_to_try
from gateway.serial_port import Port, open_port
from gateway.settings import Settings, load_settings
from p2os import BAUD_CODES

EXIT_OK = 0
EXIT_USAGE = 2
SWITCH_INTERVAL = 0.001
"""Seconds after which a thread yields to others; the default of Python, 0.005, adds to the latencies."""

EPILOG = """\
examples:
  p2os-gateway /dev/ttyUSB0                            a robot on an adapter, under the name it gives itself
  p2os-gateway /tmp/happy --name happy --wait          an emulated one, also if it is not there yet
  p2os-gateway socket://localhost:8101                 behind a TCP bridge
  p2os-gateway /dev/ttyS0 --baud 9600 --config happy.toml
  p2os-gateway /dev/ttyUSB0 --camera http://10.0.0.7/video
                                                       with the pictures of its IP camera
  p2os-gateway /dev/ttyS1 --radio                      a robot behind radio modems

exit codes: 0 ended by a signal, 2 usage or configuration, 3 no such port, 4 not a port, 5 no permission, 6 port in use,
7 no robot answers, 8 something else answers, 9 unknown robot model, 11 another gateway has the name"""


def main(argv: Sequence[str] | None = None) -> int:
    """Run `p2os-gateway`; return its exit code."""
    parser = _parser()
    arguments = parser.parse_args(argv)
    if arguments.radio and arguments.baud not in (None, RADIO_BAUD):
        parser.error(f"radio modems know {RADIO_BAUD} bit/s only; leave out --baud, or --radio")
    sys.setswitchinterval(SWITCH_INTERVAL)
    try:
        settings = Settings() if arguments.config is None else load_settings(arguments.config)
        settings = replace(settings, radio=settings.radio or arguments.radio)
        options = GatewayOptions(
            port=arguments.port,
            name=arguments.name,
            bus=arguments.bus,
            waits=arguments.wait,
            forces=arguments.force,
            is_quiet=arguments.quiet,
            is_json=arguments.json,
        )
        cables = [(kind, address) for kind in cable_kinds() if (address := getattr(arguments, kind.name)) is not None]
        for kind, address in cables:
            kind.check(address)
            settings = replace(settings, fitted=replace(settings.fitted, **kind.fitted))
        with _signals(_end):
            _serve(options, settings, arguments.baud, cables)
    except _EndedEarly:
        return EXIT_OK
    except ConfigError as error:
        return _fail(error, EXIT_USAGE)
    except PortBusy as error:
        held = " and ".join(map(str, holders(arguments.port)))
        return _fail(f"{error}; it is held by {held}" if held else error, error.exit_code)
    except GatewayError as error:
        return _fail(error, error.exit_code)
    return EXIT_OK


def _serve(
    options: GatewayOptions,
    settings: Settings,
    baud: int | None,
    addresses: Sequence[tuple[CableKind, str]],
) -> None:
    find_model = model_finder(settings)
    port = _open_first(options)
    cables = [kind.open(address, settings, options.waits) for kind, address in addresses]
    rates = rates_to_try(port, RADIO_BAUD if settings.radio else baud)
    driver = Driver(find_model, rates, settings, probe_rates=rates_to_probe(port, settings, rates))
    bridge = Bridge(driver, port, lambda: open_port(options.port))
    gateway = Gateway(options, settings, driver, bridge, steady_clock(), cables)
    with _signals(lambda *_: bridge.stop()), ExitStack() as leaving:
        # On leaving, in this order and each even if one fails: stop the elements, stop the robot, leave the bus.
        leaving.callback(gateway.close)
        leaving.callback(bridge.close)
        for cable in cables:
            leaving.callback(cable.halt)
        for cable in cables:
            cable.start()
        bridge.run(gateway)


class _EndedEarly(BaseException):
    """A signal ended the program before there was anything to stop; no `Exception`, so that no handler catches it."""


def _end(number: int, frame: FrameType | None) -> NoReturn:
    raise _EndedEarly


@contextmanager
def _signals(handler: Callable[[int, FrameType | None], object]) -> Iterator[None]:
    """Let SIGINT and SIGTERM call this handler meanwhile."""
    before = {number: signal.signal(number, handler) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for number, earlier in before.items():
            signal.signal(number, earlier)


def _open_first(options: GatewayOptions) -> Port:
    """Open the port; wait for it only if asked to."""
    is_told = False
    diagnosis, reports = LinkDiagnosis(), LinkReports()
    while True:
        try:
            return open_port(options.port)
        except NoSuchPort as error:
            if not options.waits:
                raise
            diagnosis.begin(steady_clock())
            diagnosis.note_no_port(str(error))
        if not is_told:
            report_event(options, f"waiting for {options.port}", {"event": "waiting"})
            is_told = True
        report_problem(options, reports.due(diagnosis.problem(steady_clock()), steady_clock()))
        time.sleep(REOPEN_PERIOD)


def _parser() -> argparse.ArgumentParser:
    parser = CommandParser(
        prog="p2os-gateway",
        description="Bring a robot on a port to the bus: odometry, sonar and more under NAME/; NAME/cmd_vel drives it.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_version()
    parser.add_argument("port", metavar="PORT", help="a device, socket://HOST:PORT or rfc2217://HOST:PORT")
    parser.add_argument("--name", help="name of the robot on the bus [the robot's own name]")
    parser.add_argument("--baud", type=_baud, metavar="auto|N", help="connect at this rate only, bit/s [auto]")
    parser.add_argument("--radio", action="store_true", help="dial a radio modem, and send only what it carries")
    for kind in cable_kinds():
        parser.add_argument(f"--{kind.name}", metavar=kind.metavar, help=kind.help)
    parser.add_argument("--config", type=Path, metavar="FILE", help="read the settings of this robot from a TOML file")
    parser.add_argument(
        "--bus",
        default=default_bus(),
        metavar="PROFILE",
        help="profile of the bus: local[:NAME] (this machine only), lan, router, secure[:FOLDER OF KEYS], or a file "
        f"[%(default)s; {VARIABLE} changes it]",
    )
    parser.add_argument("--wait", action="store_true", help="search for port and robot until they appear")
    parser.add_argument(
        "--force", action="store_true", help="wait until another gateway of this name has ended, then take its place"
    )
    parser.add_argument("--quiet", action="store_true", help="print errors only")
    parser.add_argument("--json", action="store_true", help="print events as JSON, one line each")
    return parser


def _baud(text: str) -> int | None:
    if text == "auto":
        return None
    rates = sorted(BAUD_CODES.values())
    if not text.isdecimal() or int(text) not in rates:
        raise argparse.ArgumentTypeError(f"{text!r} is no rate; use auto or one of {', '.join(map(str, rates))}")
    return int(text)


def _fail(error: Exception | str, code: int) -> int:
    print(f"p2os-gateway: {error}", file=sys.stderr)
    return code


if __name__ == "__main__":
    sys.exit(main())

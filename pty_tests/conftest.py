"""Where the suite finds its robots: on the port it is given, or in emulators it starts itself.

One emulator per model serves a whole session (of one xdist worker); each test gets a connection of its own.
"""

import json
import os
import select
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass

import pytest
import serial

from pty_tests import summary
from pty_tests.client import CLOSE, CONFIG, ENABLE, SETA, SETO, SETRA, SETRV, SETV, STOP, Client, Silence
from pty_tests.firmware import Firmware, reported, told
from pty_tests.models import MODELS, Model
from pty_tests.packets import CONFIGPAC, parse_configuration
from tests.waiting import Deadline, exit_code

# Every firmware family, odd factors, empty sonar slots. The world is the empty one unless "@WORLD" says otherwise;
# ":PART,PART" fits accessories.
EMULATED = ("powerbot", "p3dx-sh", "p2dx", "powerbot-sh", "amigo")
OLD_FIRMWARE = {"P2OS": "P2OS 1.M"}  # of emulated robots whose CONFIGpac has no version, by family


def pytest_addoption(parser: pytest.Parser) -> None:
    group = parser.getgroup("P2OS conformance")
    group.addoption(
        "--port",
        action="append",
        default=[],
        help="judge the robot on this port (device path or socket://host:port); repeat for more; default: emulators",
    )
    group.addoption("--baud", type=int, default=9600, help="rate of the line to --port (default 9600)")
    group.addoption("--model", help="subtype to emulate, or that the robot on --port must announce")
    group.addoption("--firmware", help="what the robot runs, as P2OS 1.M; default: what it reports")
    group.addoption("--laser", help="port of a SICK LMS200, at 9600 bit/s, beside the robot on --port")
    group.addoption("--report", help="write what the robot answers to unverified matters into this file (JSON)")
    group.addoption("--may-move", action="store_true", help="the robot on --port has 2 m of free floor around it")


def pytest_configure(config: pytest.Config) -> None:
    if config.getoption("--report") and hasattr(config, "workerinput"):
        raise pytest.UsageError("--report writes one file: run without -n")
    if text := config.getoption("--firmware"):
        try:
            told(text)
        except ValueError as error:
            raise pytest.UsageError(f"--firmware: {error}") from None
    ports, laser = config.getoption("--port"), config.getoption("--laser")
    for option in "--model", "--laser":
        if len(ports) > 1 and config.getoption(option):
            raise pytest.UsageError(f"{option} is for one robot; give one --port")
    for option, port in [*(("--port", port) for port in ports), *([("--laser", laser)] if laser else [])]:
        _check_port(option, port)
    config.addinivalue_line("markers", "moves: the robot drives or turns; on --port only with --may-move")
    config.addinivalue_line(
        "markers", "emulate(*models): which emulated models suffice for this test, to keep the suite short"
    )
    config.addinivalue_line(
        "markers",
        "needs(*commands): asked only of firmware that knows them; without any, that knows the parameter `number`",
    )


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """List the robots that were asked, and the tests that were not run, with the reasons."""
    own = [
        (outcome, report)
        for outcome, reports in terminalreporter.stats.items()
        for report in reports
        if isinstance(report, pytest.TestReport) and report.nodeid.startswith(f"{__package__}/")
    ]
    found = summary.lines(
        [report for outcome, report in own if outcome == "skipped"],
        [report for outcome, report in own if outcome != "skipped"],
    )
    if found:
        terminalreporter.section("conformance")
        terminalreporter.write_line("\n".join(found))


def _check_port(option: str, port: str) -> None:
    """Complain once of a port that is none, and not in every test."""
    try:
        serial.serial_for_url(port).close()
    except (OSError, ValueError) as error:
        why = os.strerror(error.errno) if isinstance(error, OSError) and error.errno else error
        raise pytest.UsageError(
            f"{option} {port} cannot be opened: {why}; give a device or socket://host:port"
        ) from None


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    if config.getoption("--port") and not config.getoption("--may-move"):
        for item in items:
            if item.get_closest_marker("moves"):
                item.add_marker(pytest.mark.skip(reason="moves the robot: give --may-move where there is room"))


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    if "site" not in metafunc.fixturenames:
        return
    if ports := metafunc.config.getoption("--port"):
        models = ports
    elif chosen := metafunc.config.getoption("--model"):
        models = [chosen]
    else:
        mark = metafunc.definition.get_closest_marker("emulate")
        models = list(mark.args if mark else EMULATED)
    metafunc.parametrize("site", models, indirect=True, scope="package")


@dataclass(frozen=True, slots=True)
class Site:
    """A port with a robot behind it.

    model: the subtype it announces. laser: the port of its laser. firmware: what it runs, where somebody has said so.
    """

    port: str
    baud: int
    model: str
    emulated: bool
    laser: str | None = None
    firmware: str | None = None


@pytest.fixture(scope="package")  # and no longer: the emulator would go on beside all other tests of a worker
def site(request: pytest.FixtureRequest) -> Iterator[Site]:
    """The robot under test."""
    baud = request.config.getoption("--baud")
    if request.param in request.config.getoption("--port"):
        port = request.param
        with Client(port, baud) as client:
            announced = client.sync().subtype.lower()
            client.hang_up()
        wanted = request.config.getoption("--model") or announced
        assert announced == wanted, f"the robot on {port} announces {announced}, not {wanted}"
        laser, firmware = (request.config.getoption(option) for option in ("--laser", "--firmware"))
        yield Site(port, baud, announced, emulated=False, laser=laser, firmware=firmware)
        return
    robot, _, world = request.param.partition("@")
    model, _, parts = robot.partition(":")
    fit = ["--fit", parts] if parts else []
    with subprocess.Popen(
        [sys.executable, "-m", "p2os_emu", "--robot", model, "--world", world or "empty", "--json", *fit],
        stdout=subprocess.PIPE,
        text=True,
    ) as emulator:
        try:
            port, laser = ports_of(emulator)
            family = MODELS[model].firmware if model in MODELS else ""
            yield Site(port, baud, model, emulated=True, laser=laser, firmware=OLD_FIRMWARE.get(family))
            assert emulator.poll() is None, f"the emulator ended by itself with code {emulator.returncode}"
        finally:
            emulator.terminate()
            exit_code(emulator)


def ports_of(emulator: "subprocess.Popen[str]") -> tuple[str, str | None]:
    """Wait for the line that says every robot is ready; return the first robot's port and its laser's."""
    assert emulator.stdout is not None
    deadline = Deadline()
    while not select.select([emulator.stdout], [], [], deadline.left)[0]:
        assert not deadline.has_passed(), deadline.in_words("the emulator says where it listens")
    line = emulator.stdout.readline()
    assert line, f"the emulator ended with code {exit_code(emulator)} before it was ready"
    robot = json.loads(line)["robots"][0]
    return str(robot["port"]), robot["laser_port"]


@pytest.fixture(scope="package")
def firmware(site: Site) -> Firmware:
    """What the robot runs, by its CONFIGpac where nobody has said so."""
    if site.firmware is not None:
        return told(site.firmware)
    with Client(site.port, site.baud) as client:
        client.connect()
        client.send(CONFIG)
        try:
            configuration = parse_configuration(client.next(CONFIGPAC))
        except Silence:
            configuration = None  # older than P2OS 1.4, or no such robot: other tests tell
        client.hang_up()
    return reported(site.model, configuration)


@pytest.fixture(autouse=True)
def only_what_the_firmware_knows(request: pytest.FixtureRequest) -> None:
    """Skip a test of a robot that needs commands which its firmware does not know."""
    if "site" not in request.fixturenames:
        return
    firmware: Firmware = request.getfixturevalue("firmware")
    site: Site = request.getfixturevalue("site")
    request.node.user_properties.append((summary.FIRMWARE, f"{site.model}, {firmware}"))
    for mark in request.node.iter_markers("needs"):
        for number in mark.args or (request.node.callspec.params["number"],):
            firmware.require(number)


@pytest.fixture
def line(site: Site) -> Iterator[Client]:
    """A cable to a robot that waits for a handshake and is silent."""
    with Client(site.port, site.baud) as client:
        client.hang_up()
        yield client
        client.send(CLOSE, 1)
        assert not client.complaints


@pytest.fixture
def robot(site: Site) -> Iterator[Client]:
    """A connected robot, SIPs running, motors off."""
    with Client(site.port, site.baud) as client:
        client.connect()
        yield client
        client.send(STOP)
        client.send(CLOSE, 1)
        assert not client.complaints


@pytest.fixture
def model(site: Site) -> Model:
    """The factors of the robot under test."""
    if site.model not in MODELS:
        pytest.skip(f"the suite holds no factors for {site.model!r}: it knows {', '.join(sorted(MODELS))}")
    return MODELS[site.model]


@pytest.fixture
def driven(robot: Client) -> Iterator[Client]:
    """A robot at rest with its motors on, at the origin of its odometry, with brisk and known limits.

    The next test finds it at rest: without power it rolls on for a while.
    """
    robot.send(STOP)
    for number, value in (
        (SETV, 600),
        (SETA, 400),
        (SETA, -400),
        (SETRV, 90),
        (SETRA, 150),
        (SETRA, -150),
        (ENABLE, 1),
    ):
        robot.send(number, value)
    robot.sip(lambda sip: sip.motors and sip.at_rest, "SIP with motors on and wheels still", 5.0)
    robot.send(SETO)
    robot.sip(lambda sip: not (sip.x or sip.y or sip.heading), "SIP with the odometry at its origin")
    yield robot
    robot.send(STOP)
    robot.sip(lambda sip: sip.at_rest, "SIP of a robot that has come to rest", 6.0)

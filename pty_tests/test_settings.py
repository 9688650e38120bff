"""Settings that a client changes, and the ways to get the factory's back."""

from collections.abc import Iterator

import pytest

from pty_tests.client import BATTERYINFO, CLOSE, CONFIG, RESET, Client
from pty_tests.conftest import Site
from pty_tests.firmware import ADSEL, BATTEST, BUMPSTALL
from pty_tests.packets import CONFIGPAC, Sip, parse_configuration

GAINS = {82: "rot_kp", 83: "rot_kv", 84: "rot_ki", 85: "trans_kp", 86: "trans_kv", 87: "trans_ki"}
CALIBRATION = {38: "gyro_cw", 39: "gyro_ccw", 88: "rev_count", 89: "drift_factor", 93: "ticks_mm"}
DIRECTIONAL = (14, 20)

ARCOS = pytest.mark.emulate("p3dx-sh:gyro")


def configuration(robot: Client) -> dict[str, int | str]:
    robot.send(CONFIG)
    return parse_configuration(robot.next(CONFIGPAC))


@ARCOS
@pytest.mark.needs
@pytest.mark.parametrize("number", GAINS)
def test_a_gain_is_set_and_read_back(robot: Client, number: int) -> None:
    before = configuration(robot)[GAINS[number]]
    assert isinstance(before, int)
    robot.send(number, before + 1)
    assert configuration(robot)[GAINS[number]] == before + 1
    robot.send(number, before)


@ARCOS
@pytest.mark.needs
@pytest.mark.parametrize(("number", "name"), CALIBRATION.items())
def test_a_calibration_is_set_and_read_back(robot: Client, number: int, name: str) -> None:
    before = configuration(robot).get(name)
    if not isinstance(before, int):
        pytest.skip(f"this firmware's CONFIGpac has no {name}")
    robot.send(number, before + 1)
    assert configuration(robot)[name] == before + 1
    robot.send(number, before)


@ARCOS
@pytest.mark.parametrize("number", DIRECTIONAL)
def test_directional_limits_are_taken_without_complaint(robot: Client, number: int) -> None:
    for value in (50, -50):
        robot.send(number, value)
    assert all(sip.at_rest for sip in robot.sips(3))


@ARCOS
@pytest.mark.needs(ADSEL)
def test_the_sip_reports_the_analog_port_that_was_selected(robot: Client) -> None:
    robot.send(ADSEL, 3)
    robot.sip(lambda sip: sip.analog_port == 3, "SIP with analog port 3")
    robot.send(ADSEL, 0)


@ARCOS
@pytest.mark.needs(BUMPSTALL)
def test_bumpstall_does_not_stall_a_robot_that_touches_nothing(robot: Client) -> None:
    for value in (0, 1, 2, 3):
        robot.send(BUMPSTALL, value)
    assert all(not (sip.rear_byte & 1 or sip.front_byte & 1) for sip in robot.sips(3))


@ARCOS
@pytest.mark.needs(BATTEST)
def test_a_pretended_battery_shows_until_it_is_taken_back(robot: Client) -> None:
    true = robot.fresh_sip().battery
    robot.send(BATTEST, 105)
    robot.sip(lambda sip: sip.battery == 105, "SIP with 10.5 V")
    robot.send(BATTEST, 0)
    robot.sip(lambda sip: abs(sip.battery - true) <= 2, "SIP with the true voltage")


@ARCOS
def test_batteryinfo_ends_nothing(robot: Client) -> None:
    robot.send(BATTERYINFO, 1)
    assert len(robot.sips(3)) == 3


@pytest.fixture
def spare(site: Site) -> Iterator[Client]:
    """A connected robot that a test may reset: an emulated one."""
    if not site.emulated:
        pytest.skip("resets the controller: only of an emulated robot")
    with Client(site.port, site.baud) as client:
        client.connect()
        yield client
        client.send(CLOSE, 1)


@pytest.mark.emulate("powerbot-sh")
@pytest.mark.needs(RESET)
def test_reset_says_so_and_leaves_a_robot_that_waits_for_a_handshake(spare: Client) -> None:
    spare.send(RESET)
    reset = spare.wait(lambda payload: payload[0] in (0xFE, 0xFF), "reset packet", 2.0, pulse=False)
    assert not Sip.is_one(reset)
    assert spare.greets(2.0)

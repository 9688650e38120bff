"""Getting into a conversation and out of it in every way the old clients do it.

The windows are the old clients': Player reads the SYNC0 answer once, 0.4 s after it sent; ARIA gives every answer 1 s.
"""

import pytest

from pty_tests.client import (
    CLOSE,
    CONFIG,
    ENABLE,
    HOSTBAUD,
    OPEN,
    PULSE,
    RESET,
    SONAR,
    VEL,
    Client,
    command,
    frame,
    identity,
)
from pty_tests.conftest import Site
from pty_tests.packets import CONFIGPAC, Sip, parse_configuration

SYNC0, SYNC1, SYNC2 = (frame(bytes([number])) for number in range(3))
ARIA_OPEN, ARIA_CLOSE = command(OPEN, 1), command(CLOSE, 1)
PLAYER_WINDOW = 0.4  # s
# What comes before the strings is the same for all models.
ONE_MODEL = pytest.mark.emulate("p3dx-sh")
BAUD_CODES = {9600: 0, 19200: 1, 38400: 2, 57600: 3, 115200: 4}


def greet(line: Client) -> bytes:
    """The whole handshake; returns the SYNC2 answer."""
    assert line.answer(SYNC0, PLAYER_WINDOW) == b"\x00"
    assert line.answer(SYNC1) == b"\x01"
    return line.answer(SYNC2)


@ONE_MODEL
def test_each_sync_is_answered_with_its_own_bytes_within_the_clients_window(line: Client) -> None:
    assert greet(line)[0] == 2


def test_robot_announces_three_short_strings_with_class_and_subtype(line: Client, site: Site) -> None:
    announced = identity(greet(line))
    assert announced.robot_class.lower() == "pioneer"
    assert all(0 < len(text) <= 19 for text in announced), "Player and ROS copy each string into 20 bytes"
    assert announced.subtype.lower() == site.model


@ONE_MODEL
def test_noise_and_modem_dialling_before_the_handshake_are_ignored(line: Client) -> None:
    line.write(b"WMS2\r")
    line.write(bytes(range(0xFA)) * 2)  # every byte that begins no frame
    assert greet(line)[0] == 2


@ONE_MODEL
def test_a_false_start_before_the_handshake_is_ignored(line: Client) -> None:
    line.write(b"\xfa\xfa\xfb\x05\x00")  # a header, a length, and three bytes too few
    list(line.hear(0.25, pulse=False))  # the receiver drops a partial frame after 100 ms without a byte
    assert greet(line)[0] == 2


@ONE_MODEL
def test_a_bad_checksum_before_the_handshake_is_not_answered(line: Client) -> None:
    line.write(SYNC0[:-1] + b"\x01")
    assert line.answer(SYNC0) == b"\x00"
    assert line.answer(SYNC1) == b"\x01", "the damaged SYNC0 was answered too"


@ONE_MODEL
def test_sync0_restarts_the_handshake(line: Client) -> None:
    assert line.answer(SYNC0) == b"\x00"
    assert line.answer(SYNC1) == b"\x01"
    assert line.answer(SYNC0) == b"\x00"
    line.write(SYNC2)  # out of turn again, so the next answer is not its
    assert line.answer(SYNC1) == b"\x01"
    assert line.answer(SYNC2)[0] == 2


@ONE_MODEL
def test_a_repeated_sync_is_answered_again(line: Client) -> None:
    for request, number in ((SYNC0, 0), (SYNC1, 1), (SYNC2, 2)):
        assert line.answer(request)[0] == number
        assert line.answer(request)[0] == number


@ONE_MODEL
@pytest.mark.parametrize("stray", [SYNC1, SYNC2, ARIA_OPEN, ARIA_CLOSE], ids=["01", "02", "OPEN(1)", "CLOSE(1)"])
def test_a_packet_out_of_turn_gets_no_answer(line: Client, stray: bytes) -> None:
    line.write(stray)
    assert line.answer(SYNC0) == b"\x00"
    assert line.answer(SYNC1) == b"\x01"


@ONE_MODEL
def test_an_open_that_dislodges_is_not_taken_for_sync1(line: Client) -> None:
    assert line.answer(SYNC0) == b"\x00"
    line.write(ARIA_OPEN)
    assert line.answer(SYNC1) == b"\x01"
    assert line.answer(SYNC2)[0] == 2


@ONE_MODEL
def test_commands_before_open_are_ignored(line: Client) -> None:
    for raw in (command(CONFIG), command(ENABLE, 1), command(VEL, 100)):
        line.write(raw)
    greet(line)
    for raw in (command(CONFIG), command(ENABLE, 1), command(VEL, 100)):
        line.write(raw)
    line.write(command(OPEN))
    heard = line.record(3)
    assert all(Sip.is_one(item.payload) for item in heard), "a CONFIG before OPEN was answered"
    last = Sip.parse(heard[-1].payload)
    assert not last.motors
    assert last.at_rest


@ONE_MODEL
@pytest.mark.parametrize("opening", [command(OPEN), ARIA_OPEN], ids=["without argument", "with 1"])
def test_open_starts_the_stream(line: Client, opening: bytes) -> None:
    greet(line)
    assert Sip.is_one(line.answer(opening, 1.0))
    assert len(line.sips(3)) == 3


@ONE_MODEL
def test_motors_are_off_after_open_whatever_they_were_before(robot: Client) -> None:
    robot.send(ENABLE, 1)
    robot.motors_become(True)
    robot.sync()
    robot.write(command(OPEN))
    assert not robot.sip().motors


@ONE_MODEL
def test_sync0_while_connected_is_a_pulse_and_no_handshake(robot: Client) -> None:
    robot.forget()
    for _ in range(3):
        robot.send(PULSE)
    assert all(Sip.is_one(heard.payload) for heard in robot.record(3))


@ONE_MODEL
@pytest.mark.parametrize("closing", [command(CLOSE), ARIA_CLOSE], ids=["without argument", "with 1"])
def test_close_ends_the_stream_at_once(robot: Client, closing: bytes) -> None:
    robot.send(ENABLE, 1)
    robot.send(SONAR, 1)
    robot.motors_become(True)
    robot.forget()  # what has come while this program did not read
    robot.write(closing)
    late = list(robot.hear(0.45, pulse=False))
    assert len(late) <= 1, f"{len(late)} frames after CLOSE; one may have been on its way"
    assert robot.answer(SYNC0) == b"\x00"


@ONE_MODEL
def test_a_second_client_connects_after_the_first_has_left(site: Site) -> None:
    for _ in range(2):
        with Client(site.port, site.baud) as client:
            client.connect()
            client.sips(2)
            client.send(CLOSE)


@ONE_MODEL
def test_a_second_client_connects_after_the_first_has_vanished(site: Site) -> None:
    with Client(site.port, site.baud) as first:
        first.connect()
        first.send(ENABLE, 1)
        first.motors_become(True)
    with Client(site.port, site.baud) as second:
        second.connect()
        assert not second.sip().motors
        second.send(CLOSE)


@ONE_MODEL
@pytest.mark.needs(RESET)
def test_reset_ends_the_conversation_and_the_robot_comes_back(robot: Client) -> None:
    robot.send(ENABLE, 1)
    robot.motors_become(True)
    robot.send(RESET)
    assert any(robot.greets(0.5) for _ in range(10)), "no handshake for 5 s"
    robot.connect()
    assert not robot.sip().motors


@ONE_MODEL
@pytest.mark.needs(HOSTBAUD)
def test_hostbaud_is_accepted(robot: Client, site: Site) -> None:
    robot.send(HOSTBAUD, BAUD_CODES[site.baud])
    robot.send(PULSE)
    robot.forget()
    assert len(robot.sips(3)) == 3
    robot.send(CONFIG)
    configuration = parse_configuration(robot.next(CONFIGPAC))
    assert configuration["host_baud"] == BAUD_CODES[site.baud]

import pytest
from hypothesis import given
from hypothesis import strategies as st

from p2os import ConnectionState, HostHandshake, Identity, LocalProtocolError, RobotHandshake, encode_frame

ROBOT = Identity("MyRobot", "Pioneer", "p3dx-sh")
# Source: transcript of a handshake; payloads of the robot's answers.
WELCOME = bytes.fromhex("02 4D 79 52 6F 62 6F 74 00 50 69 6F 6E 65 65 72 00 70 33 64 78 2D 73 68 00")
SYNC0, SYNC1, SYNC2 = b"\x00", b"\x01", b"\x02"
ARIA_OPEN, ARIA_CLOSE = b"\x01\x3b\x01\x00", b"\x02\x3b\x01\x00"
SIP = bytes([0x32, *bytes(24)])


def answers(*payloads: bytes) -> list[bytes | None]:
    """What a new robot answers to these payloads."""
    robot = RobotHandshake(ROBOT)
    return [robot.receive(payload) for payload in payloads]


def robot_after(*payloads: bytes) -> RobotHandshake:
    robot = RobotHandshake(ROBOT)
    for payload in payloads:
        robot.receive(payload)
    return robot


def test_the_welcome_frame_is_that_of_the_transcript() -> None:
    frame = "FA FB 1B 02 4D 79 52 6F 62 6F 74 00 50 69 6F 6E 65 65 72 00 70 33 64 78 2D 73 68 00 B7 74"
    assert answers(SYNC0, SYNC1, SYNC2) == [SYNC0, SYNC1, WELCOME]
    assert encode_frame(WELCOME) == bytes.fromhex(frame)


def test_the_welcome_of_a_powerbot_is_that_of_the_transcript() -> None:
    robot = RobotHandshake(Identity("PowerBot1", "Pioneer", "powerbot-sh"))
    welcome = [robot.receive(sync) for sync in (SYNC0, SYNC1, SYNC2)][2]
    assert welcome is not None
    assert encode_frame(welcome) == bytes.fromhex(
        "FA FB 21 02 50 6F 77 65 72 42 6F 74 31 00 50 69 6F 6E 65 65 72 0070 6F 77 65 72 62 6F 74 2D 73 68 00 EA CC"
    )


@pytest.mark.parametrize("open_command", [b"\x01", ARIA_OPEN])
@pytest.mark.parametrize("close_command", [b"\x02", ARIA_CLOSE])
def test_open_and_close_work_with_and_without_argument(open_command: bytes, close_command: bytes) -> None:
    robot = robot_after(SYNC0, SYNC1, SYNC2)
    states = [robot.state]
    for command in (open_command, close_command):
        assert robot.receive(command) is None
        states.append(robot.state)
    assert states == [ConnectionState.SYNCED, ConnectionState.OPEN, ConnectionState.WAIT]


def test_sync0_restarts_the_sequence_anywhere_in_it() -> None:
    assert answers(SYNC0, SYNC0, SYNC1, SYNC0, SYNC1, SYNC2, SYNC0) == [
        SYNC0,
        SYNC0,
        SYNC1,
        SYNC0,
        SYNC1,
        WELCOME,
        SYNC0,
    ]


def test_a_repeat_of_the_sync_answered_last_is_answered_again() -> None:
    assert answers(SYNC0, SYNC0, SYNC1, SYNC1, SYNC2, SYNC2) == [SYNC0, SYNC0, SYNC1, SYNC1, WELCOME, WELCOME]


@pytest.mark.parametrize("before", [(), (SYNC0,), (SYNC0, SYNC1)])
@pytest.mark.parametrize("stray", [SYNC1, SYNC2, ARIA_OPEN, ARIA_CLOSE, SIP, b"\x0b\x3b\xc8\x00", b"\x00\x3b\x01\x00"])
def test_what_is_out_of_turn_is_not_answered(before: tuple[bytes, ...], stray: bytes) -> None:
    in_turn = {(): SYNC0, (SYNC0,): SYNC1, (SYNC0, SYNC1): SYNC2}[before]
    if stray not in (in_turn, *before[-1:]):
        assert answers(*before, stray)[-1] is None


def test_a_client_that_closes_first_gets_no_welcome() -> None:
    assert answers(SYNC2, SYNC0, SYNC1, SYNC2) == [None, SYNC0, SYNC1, WELCOME]


def test_a_close_with_argument_ends_a_handshake_half_done() -> None:
    assert answers(SYNC0, SYNC1, ARIA_CLOSE, SYNC2) == [SYNC0, SYNC1, None, None]


def test_pulses_of_an_open_connection_are_not_answered() -> None:
    robot = robot_after(SYNC0, SYNC1, SYNC2, b"\x01")
    assert [robot.receive(payload) for payload in (b"\x00", b"\x01", b"\x00")] == [None, None, None]
    assert robot.state is ConnectionState.OPEN


def test_a_reset_robot_waits() -> None:
    robot = robot_after(SYNC0, SYNC1, SYNC2, b"\x01")
    robot.reset()
    assert robot.state is ConnectionState.WAIT


@given(st.lists(st.binary(max_size=5) | st.sampled_from([SYNC0, SYNC1, SYNC2, ARIA_OPEN, ARIA_CLOSE]), max_size=30))
def test_whatever_came_before_sync0_then_1_then_2_connects_a_robot_that_is_not_open(payloads: list[bytes]) -> None:
    robot = robot_after(*payloads)
    if robot.state is ConnectionState.OPEN:
        robot.receive(ARIA_CLOSE)
    assert [robot.receive(sync) for sync in (SYNC0, SYNC1, SYNC2)] == [SYNC0, SYNC1, WELCOME]


@pytest.mark.parametrize("name", ["x" * 20, "a\0b"])
def test_a_name_that_clients_cannot_hold_is_refused(name: str) -> None:
    with pytest.raises(LocalProtocolError, match="does not fit the SYNC2 answer, which carries 19 characters"):
        RobotHandshake(Identity(name, "Pioneer", "p3dx-sh"))


def test_host_and_robot_shake_hands() -> None:
    host, robot = HostHandshake(), RobotHandshake(ROBOT)
    for _ in range(3):
        answer = robot.receive(host.request()[3:-2])
        assert answer is not None
        host.receive(answer)
    assert host.identity == ROBOT


def test_host_repeats_its_request_until_it_is_answered() -> None:
    host = HostHandshake()
    assert host.request() == host.request() == encode_frame(SYNC0)
    assert host.receive(SYNC1) is None  # a late answer from before
    assert host.request() == encode_frame(SYNC0)
    host.receive(SYNC0)
    host.receive(SYNC0)  # answered twice, as both our requests arrived
    assert host.request() == encode_frame(SYNC1)


@pytest.mark.parametrize("packet", [SIP, b"\x33" + SIP[1:]])
def test_host_notices_a_robot_that_is_still_streaming(packet: bytes) -> None:
    host = HostHandshake()
    host.receive(SYNC0)
    host.receive(packet)
    assert host.streaming
    assert host.request() == encode_frame(SYNC0)
    host.receive(SYNC0)
    assert not host.streaming


def test_host_starts_again_when_the_robot_lost_count() -> None:
    host = HostHandshake()
    host.receive(SYNC0)
    host.receive(b"\xff")
    assert host.request() == encode_frame(SYNC0)
    assert not host.streaming


@pytest.mark.parametrize("answer", [SYNC2, b"\x02\x00", b"\x02abc\0", b"\x02abc\0def\0", b"\x02a\0\0\0"])
def test_host_takes_no_welcome_without_three_strings(answer: bytes) -> None:
    host = HostHandshake()
    for payload in (SYNC0, SYNC1, answer):
        assert host.receive(payload) is None
    assert host.receive(WELCOME) == ROBOT


@given(st.lists(st.binary(max_size=40), max_size=20))
def test_no_answer_makes_the_host_fail(payloads: list[bytes]) -> None:
    host = HostHandshake()
    for payload in payloads:
        host.receive(payload)
        assert host.request()[:2] == b"\xfa\xfb"

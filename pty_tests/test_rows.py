"""Every row of the protocol page: what asks for packets, and what must not disturb."""

import re
from pathlib import Path

import pytest

from pty_tests.client import ENABLE, VEL, Client, command
from pty_tests.packets import Sip
from pty_tests.rows import ELSEWHERE, PACKETS, QUIET, REQUESTS, Request

PAGE = Path(__file__).resolve().parents[1] / "PROTOCOL.md"

# A Pioneer 3 with everything that hangs on its controller, and an AmigoBot for its sounds.
FITTED = pytest.mark.emulate("p3dx-sh:gripper,gyro,compass,joystick,arm,ptz", "amigo")
ONE_MODEL = pytest.mark.emulate("p3dx-sh:gripper,gyro,compass,joystick,arm,ptz")


def page_numbers(heading: str, base: int) -> set[int]:
    """The numbers at the beginning of the rows under a heading of the page."""
    section = PAGE.read_text(encoding="utf-8").partition(f"## {heading}\n")[2].partition("\n## ")[0]
    return {int(number, base) for number in re.findall(r"^\| (0x[0-9A-F]+|\d+) ", section, re.MULTILINE)}


def has_page() -> bool:
    return PAGE.is_file()


@pytest.mark.skipif(not has_page(), reason="the protocol page is not beside the suite")
def test_every_command_of_the_page_is_judged_once() -> None:
    judged = [
        *QUIET,
        *(request.number for request in REQUESTS.values()),
        *(number for numbers in ELSEWHERE.values() for number in numbers),
    ]
    assert sorted(judged) == sorted(set(judged))
    assert page_numbers("Commands to the robot", 10) == set(judged)


@pytest.mark.skipif(not has_page(), reason="the protocol page is not beside the suite")
def test_every_packet_of_the_page_is_judged_once() -> None:
    judged = [packet for packets in PACKETS.values() for packet in packets]
    assert sorted(judged) == sorted(set(judged))
    assert page_numbers("Packets from the robot", 16) == set(judged)


def count(robot: Client, request: Request, sips: int) -> int:
    """How many of the packet come beside so many SIPs, each of them as it must be."""
    found = [heard.payload for heard in robot.record(sips) if heard.payload[0] == request.packet]
    for payload in found:
        request.check(payload)
    return len(found)


@FITTED
@pytest.mark.parametrize("name", REQUESTS)
def test_an_accessory_packet_comes_when_it_is_asked_for_and_only_then(robot: Client, name: str) -> None:
    request = REQUESTS[name]
    assert count(robot, request, 3) == 0, "sent without being asked for"
    ask = request.once if request.once is not None else request.always
    robot.send(request.number, ask)
    if count(robot, request, 8) == 0:
        pytest.skip("the robot does not answer: it has no such accessory")
    if request.always is not None:
        robot.send(request.number, request.always)
        assert count(robot, request, 10) >= 3
    if request.stop is not None:
        robot.send(request.number, request.stop)
        robot.fresh_sip()
        assert count(robot, request, 4) == 0, "sent after it was stopped"


@ONE_MODEL
@pytest.mark.parametrize("number", QUIET)
def test_a_command_that_concerns_something_else_does_not_disturb(robot: Client, number: int) -> None:
    for value in QUIET[number].values:
        robot.send(number, value)
    for heard in robot.record(3):
        assert Sip.is_one(heard.payload), f"command {number} was answered by {heard.payload.hex(' ')}"
        sip = Sip.parse(heard.payload)
        assert sip.at_rest
        assert not sip.motors


@ONE_MODEL
def test_all_quiet_commands_in_one_go_do_not_disturb_either(robot: Client) -> None:
    robot.write(b"".join(command(row.number, value) for row in QUIET.values() for value in row.values))
    assert all(sip.at_rest for sip in robot.sips(5))


@ONE_MODEL
@pytest.mark.moves
def test_a_driving_robot_is_not_disturbed_by_what_concerns_something_else(driven: Client) -> None:
    driven.send(VEL, 200)
    driven.sip(lambda sip: sip.left > 150 and sip.right > 150, "SIP of a driving robot", 5.0)
    halting = {57, 76}  # an emergency stop, and parking an arm, may well stop a robot
    for row in QUIET.values():
        if row.number not in halting:
            driven.send(row.number, row.values[-1])
    assert all(sip.left > 150 and sip.right > 150 for sip in driven.sips(5))
    driven.send(ENABLE, 0)

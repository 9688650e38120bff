"""AUX ports: what a client asks for, it gets whole or not at all."""

import pytest

from pty_tests.client import Client

# port: command that writes, command that reads, packet
PORTS = {1: (42, 43, 0xB0), 2: (66, 67, 0xB8), 3: (60, 61, 0xC8)}
CANON_POWER_ON = bytes.fromhex("FF 30 30 00 A0 31 EF")

ONE_MODEL = pytest.mark.emulate("p3dx-sh:ptz")


@ONE_MODEL
@pytest.mark.parametrize("port", PORTS)
def test_an_aux_port_without_bytes_says_nothing(robot: Client, port: int) -> None:
    _, read, packet = PORTS[port]
    robot.send(read, 0)
    robot.send(read, 6)
    assert packet not in {heard.payload[0] for heard in robot.record(4)}
    robot.send(read, 0)


@ONE_MODEL
def test_a_camera_on_aux1_is_heard_in_pieces_of_the_length_asked_for(robot: Client) -> None:
    """Power on: FE 30 30 ERR 30 EF comes back, and what was not asked for stays for the next question."""
    write, read, packet = PORTS[1]
    robot.send(read, 0)
    robot.send(write, CANON_POWER_ON)
    robot.send(read, 4)
    answers = [heard.payload for heard in robot.record(15) if heard.payload[0] == packet]
    if not answers:
        pytest.skip("no Canon camera answers on AUX1")
    assert answers == [bytes([packet, 0xFE, 0x30, 0x30, answers[0][4]])]
    robot.send(read, 2)
    rest = robot.next(packet, 3.0)
    assert len(rest) == 3
    assert rest[-1] == 0xEF
    robot.send(read, 0)

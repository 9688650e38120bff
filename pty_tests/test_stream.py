"""What a connected robot says of itself: SIPs, CONFIGpac, ENCODERpac and IOpac."""

from itertools import pairwise
from statistics import median

import pytest

from pty_tests.client import CONFIG, ENABLE, ENCODER, IOREQUEST, SETO, Client, Heard, command
from pty_tests.conftest import Site
from pty_tests.firmware import Firmware
from pty_tests.packets import (
    CONFIGPAC,
    ENCODERPAC,
    IOPAC,
    Sip,
    parse_configuration,
    parse_encoders,
    parse_inputs_outputs,
)

# Where the model is no question.
ONE_MODEL = pytest.mark.emulate("p3dx-sh")
LIMITS = """
    rot_vel_top trans_vel_top rot_acc_top trans_acc_top rot_vel_max trans_vel_max
    rot_acc rot_decel trans_acc trans_decel
"""


def configuration_of(robot: Client, *, argument: int | None = None) -> dict[str, int | str]:
    robot.write(command(CONFIG, argument))
    return parse_configuration(robot.next(CONFIGPAC))


def types(heard: list[Heard]) -> list[int]:
    return [item.payload[0] for item in heard]


@ONE_MODEL
@pytest.mark.needs(CONFIG)
def test_sips_come_at_the_cycle_the_robot_names(robot: Client) -> None:
    cycle = configuration_of(robot)["sip_cycle"]
    assert isinstance(cycle, int)
    # Twenty cycles: late ones are made up for, so the mean holds where a single gap may not; or, where the computer was
    # busy for a while and the robot is an emulated one, the median. Where those that came first made up for what was
    # before them, more are heard, and all count: the longer, the nearer to the cycle of the robot.
    heard: list[float] = []
    for _ in range(5):
        heard += [item.at for item in robot.record(21 if not heard else 20) if Sip.is_one(item.payload)]
        typical = (heard[-1] - heard[0]) / (len(heard) - 1), median(after - before for before, after in pairwise(heard))
        if pytest.approx(cycle / 1000, rel=0.2) in typical:
            break
    assert pytest.approx(cycle / 1000, rel=0.2) in typical


def test_every_sip_has_the_length_of_its_firmware_family(robot: Client, firmware: Firmware) -> None:
    for heard in robot.record(5):
        sip = Sip.parse(heard.payload)
        assert len(heard.payload) == 25 + 3 * len(sip.sonar) + firmware.sip_tail


def test_a_robot_at_rest_says_so_within_the_ranges_of_the_fields(robot: Client) -> None:
    for sip in robot.sips(5):
        assert sip.at_rest
        assert sip.x < 32768
        assert sip.y < 32768
        assert -2047 <= sip.heading <= 2048
        assert sip.battery >= 80, "a battery below 8 V feeds no robot"


def test_enable_switches_the_motor_flag(robot: Client) -> None:
    robot.send(ENABLE, 1)
    robot.motors_become(True)
    robot.send(ENABLE, 0)
    robot.motors_become(False)


def test_seto_without_the_value_it_announces_puts_the_odometry_to_zero(robot: Client) -> None:
    robot.write(bytes.fromhex("FA FB 04 07 3B 07 3B"))  # as Player and ROS send it
    assert SETO == 7
    robot.sip(lambda sip: (sip.x, sip.y, sip.heading) == (0, 0, 0), "SIP at the origin")


@pytest.mark.needs(CONFIG)
@pytest.mark.parametrize("argument", [None, 1], ids=["without argument", "with 1"])
def test_config_is_answered_in_the_order_aria_reads(robot: Client, argument: int | None) -> None:
    fields = configuration_of(robot, argument=argument)
    assert all(fields[name] for name in LIMITS.split()), f"a zero limit makes ARIA stand still: {fields}"
    assert fields["robot_class"] == "Pioneer"
    assert fields["sip_cycle"]
    assert fields["watchdog"]
    assert fields["host_baud"] in range(5)
    assert fields.get("auto_baud", 0) in (0, 1, 2)


@pytest.mark.needs(CONFIG)
def test_config_and_handshake_name_the_same_robot(site: Site) -> None:
    with Client(site.port, site.baud) as client:
        announced = client.connect()
        fields = configuration_of(client)
        client.send(2)
    assert (fields["name"], fields["robot_class"], fields["subtype"]) == tuple(announced)


@ONE_MODEL
@pytest.mark.needs
@pytest.mark.parametrize(("number", "packet"), [(ENCODER, ENCODERPAC), (IOREQUEST, IOPAC)], ids=["encoders", "I/O"])
def test_a_packet_comes_once_for_1_every_cycle_for_2_and_no_more_for_0(robot: Client, number: int, packet: int) -> None:
    assert packet not in types(robot.record(3)), "sent without being asked for"
    robot.send(number, 1)
    robot.next(packet)  # SIPs that had come before the robot was asked may be read only now
    assert types(robot.record(5)).count(packet) == 0, "sent more than once"
    robot.send(number, 2)
    robot.next(packet)
    assert types(robot.record(5)).count(packet) in (4, 5, 6)
    robot.send(number, 0)
    robot.fresh_sip()
    assert packet not in types(robot.record(3)), "sent after 0"


@pytest.mark.emulate("powerbot", "p3dx-sh")
@pytest.mark.needs(ENCODER)
def test_encoders_stand_still_with_the_robot(robot: Client) -> None:
    robot.send(ENCODER, 2)
    first, second = (parse_encoders(robot.next(ENCODERPAC)) for _ in range(2))
    assert second == pytest.approx(first, abs=5)  # a wheel may rest on the edge of a tick


@pytest.mark.needs(IOREQUEST)
def test_io_counts_agree_with_the_bytes_that_follow(robot: Client) -> None:
    robot.send(IOREQUEST, 1)
    groups = parse_inputs_outputs(robot.next(IOPAC))
    assert groups.digital_in
    assert groups.digital_out
    assert all(word < 1024 for word in groups.analog), "analog words have ten bits"

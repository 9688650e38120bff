from collections.abc import Callable
from typing import TYPE_CHECKING

import pytest

from gateway.elements.gripper.element import ORDERS, GripperElement
from gateway.errors import CommandRefused
from gateway.events import GripperJoints, GripperSeen
from p2os import Command, Configuration, GripperReport, StandardSip
from p2os.accessories.gripper import GripperFlags

if TYPE_CHECKING:
    from tests.gateway.elements.conftest import MakeStand, Stand

IDLE_INPUTS = 0b0011_0000
"""Nothing in the beams, nothing at the paddles."""
ALL_INPUTS = {"outer_beam", "inner_beam", "left_contact", "right_contact"}


@pytest.fixture
def stand(make_stand: "MakeStand") -> "Stand":
    return make_stand(GripperElement)


def seen(stand: "Stand") -> GripperSeen:
    return [event for event in stand.announced if isinstance(event, GripperSeen)][-1]


def joints(stand: "Stand") -> GripperJoints:
    return [event for event in stand.announced if isinstance(event, GripperJoints)][-1]


def true_claims(event: GripperSeen) -> set[str]:
    return {name for name, value in event._asdict().items() if value}


def test_robot_without_a_gripper_is_asked_a_few_times_and_then_left_alone(stand: "Stand") -> None:
    stand.connect()
    heard = stand.sent()
    stand.run(10.0)
    heard += stand.sent()
    assert {command.command for command in heard} == {Command.GRIPREQUEST}
    assert stand.element.deadline == float("inf")
    assert len(heard) <= GripperElement.times
    stand.see(StandardSip(gripper_state=0x11))
    assert not stand.has_it()
    assert stand.announced == []


def test_answer_ends_the_asking_and_says_whether_there_is_a_gripper(stand: "Stand") -> None:
    stand.connect()
    stand.take(GripperReport(kind=0, state=0, grasp_time=0.2))
    assert not stand.has_it()
    stand.take(GripperReport(kind=1, state=0x11, grasp_time=0.2))
    assert stand.has_it()
    stand.sent()
    stand.run(5.0)
    assert stand.sent() == []


def test_older_firmware_says_in_its_configuration_that_there_is_a_gripper(stand: "Stand") -> None:
    stand.connect(Configuration(gripper=1))
    assert stand.has_it()


@pytest.mark.parametrize(
    ("state", "inputs", "claims"),
    [  # source: gripper manual, state byte and digital inputs
        (0b0010_0001, IDLE_INPUTS, {"paddles_open", "lift_down"}),
        (0b0001_0010, IDLE_INPUTS, {"paddles_closed", "lift_up"}),
        (0b0100_0100, IDLE_INPUTS, {"paddles_moving", "lift_moving"}),
        (0b0011_0011, IDLE_INPUTS, set()),  # both of a pair: unknown
        (0b0010_0010, 0b0000_1100, ALL_INPUTS | {"paddles_closed", "lift_down"}),
    ],
)
def test_state_and_inputs_of_a_sip_become_claims(stand: "Stand", state: int, inputs: int, claims: set[str]) -> None:
    stand.connect()
    stand.take(GripperReport(kind=1, state=0, grasp_time=0.2))
    stand.see(StandardSip(gripper_state=state, analog_port=state, digital_in=inputs))
    assert true_claims(seen(stand)) == claims


def test_state_is_found_in_the_second_byte_where_the_first_is_empty(stand: "Stand") -> None:
    stand.connect()
    stand.take(GripperReport(kind=1, state=0, grasp_time=0.2))
    stand.see(StandardSip(gripper_state=0, analog_port=0b0010_0001, digital_in=IDLE_INPUTS))
    assert true_claims(seen(stand)) == {"paddles_open", "lift_down"}


def test_peoplebots_gripper_says_beams_contacts_and_motion_in_the_second_byte(stand: "Stand") -> None:
    stand.connect()
    stand.take(GripperReport(kind=2, state=0, grasp_time=0.2))
    stand.see(StandardSip(gripper_state=0b0010_0001, analog_port=0b1110_0100, digital_in=0))
    claims = {"paddles_open", "lift_down", "paddles_moving", "lift_moving", "outer_beam", "left_contact"}
    assert true_claims(seen(stand)) == claims


def test_every_order_has_its_arguments_and_an_unknown_one_names_them_all(stand: "Stand") -> None:
    stand.connect()
    stand.sent()
    element = stand.element
    assert isinstance(element, GripperElement)
    for what, arguments in ORDERS.items():
        element.order(what)
        heard = [(command.command, command.value) for command in stand.sent()]
        assert heard == [(Command.GRIPPER, argument) for argument in arguments]
    with pytest.raises(CommandRefused, match="open, close, stop, up, down, store, deploy, halt"):
        element.order("fly")


def test_latest_order_is_heard_last(stand: "Stand") -> None:
    stand.connect()
    stand.sent()
    element = stand.element
    assert isinstance(element, GripperElement)
    for what in ("open", "up", "close", "open"):
        element.order(what)
    assert [command.value for command in stand.sent()] == [4, 2, 1]


def test_halt_takes_back_what_waits_and_stops_paddles_and_lift(stand: "Stand") -> None:
    stand.connect()
    stand.element.halt(stand.now)
    assert Command.GRIPPER not in {command.command for command in stand.sent()}  # there is none yet
    stand.take(GripperReport(kind=1, state=0, grasp_time=0.2))
    element = stand.element
    assert isinstance(element, GripperElement)
    element.order("deploy")
    element.halt(stand.now)
    assert [(command.command, command.value) for command in stand.sent()] == [(Command.GRIPPER, 15)]


@pytest.mark.parametrize("stop", [lambda element, now: element.halt(now), lambda element, now: element.order("stop")])
def test_halt_that_is_lost_is_repeated_until_paddles_and_lift_rest(
    stand: "Stand", stop: Callable[[GripperElement, float], None]
) -> None:
    stand.connect()
    stand.take(GripperReport(kind=1, state=0, grasp_time=0.2))
    element = stand.element
    assert isinstance(element, GripperElement)
    element.order("up")
    stop(element, stand.now)
    stand.sent()
    for _ in range(3):
        stand.now += 0.1
        stand.see(StandardSip(gripper_state=GripperFlags.LIFT_MOVING))
    assert [(command.command, command.value) for command in stand.sent()] == [(Command.GRIPPER, 15)]
    element.order("up")
    stand.sent()
    for _ in range(5):
        stand.now += 0.1
        stand.see(StandardSip(gripper_state=GripperFlags.LIFT_MOVING))
    assert stand.sent() == []


@pytest.mark.parametrize(("what", "arguments"), [("stop", [3, 6]), ("halt", [15])])
def test_order_to_stop_takes_back_what_waits(stand: "Stand", what: str, arguments: list[int]) -> None:
    stand.connect()
    stand.sent()
    element = stand.element
    assert isinstance(element, GripperElement)
    element.order("open")
    element.order(what)
    assert [command.value for command in stand.sent()] == arguments


def test_error_bits_are_a_fault_until_they_are_gone(stand: "Stand") -> None:
    stand.connect()
    stand.take(GripperReport(kind=1, state=0, grasp_time=0.2))
    stand.see(StandardSip(gripper_state=0b0000_1000))
    assert len(stand.element.faults) == 1
    stand.see(StandardSip(gripper_state=0b0000_0001))
    assert stand.element.faults == ()


@pytest.mark.parametrize(
    ("state", "inputs", "opening", "lift"),
    [
        (0b0010_0001, IDLE_INPUTS, 0.2, 0.0),
        (0b0001_0010, IDLE_INPUTS, 0.0, 0.07),
        (0b0001_0010, 0b0010_1000, None, 0.07),  # closed on something
        (0b0100_0100, IDLE_INPUTS, None, None),
    ],
)
def test_joints_are_where_the_switches_say_and_unknown_in_between(
    stand: "Stand", state: int, inputs: int, opening: float | None, lift: float | None
) -> None:
    stand.connect()
    stand.take(GripperReport(kind=1, state=0, grasp_time=0.2))
    stand.see(StandardSip(gripper_state=state, digital_in=inputs))
    assert joints(stand) == (opening, lift)

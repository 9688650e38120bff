"""The gripper server, with a gripper that simply follows. Bits and numbers are those of the gripper manual."""

from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from p2os.accessories.gripper import GripperOrder
from p2os.accessory_packets import GripperReport
from p2os.command_table import Command
from p2os.configuration import Configuration
from p2os.packets import IoReport
from p2os_emu.fit import Fit
from p2os_emu.gripper_model import gripper_of
from p2os_emu.microcontroller.gripper import GripperServer
from tests.p2os_emu.microcontroller.bench import STEP, MicrocontrollerBench, PlainBody, PlainGripper

BenchOf = Callable[..., MicrocontrollerBench]
MakeGripper = Callable[..., MicrocontrollerBench]

UNKNOWN = 0x33  # open and closed, up and down
OPEN, CLOSED, PADDLES_MOVING, PADDLES_ERROR = 0x01, 0x02, 0x04, 0x08
UP, DOWN, LIFT_MOVING, LIFT_ERROR = 0x10, 0x20, 0x40, 0x80


@pytest.fixture
def make(bench_of: BenchOf) -> MakeGripper:
    """A connected robot with a gripper: its wiring, then what `PlainGripper` takes."""

    def make(wiring: str = "pioneer", subtype: str = "p3dx-sh", **figures: float) -> MicrocontrollerBench:
        body = PlainBody()
        body.gripper = PlainGripper(**figures)
        bench = bench_of(subtype, body=body)
        gripper = gripper_of(Fit({"gripper": wiring}))
        assert gripper is not None
        bench.controller.board.gripper.fit(gripper)
        return bench.connect()

    return make


def order(bench: MicrocontrollerBench, *orders: int, value: int | None = None) -> None:
    for each in orders:
        bench.send(Command.GRIPPER, each)
    if value is not None:
        bench.send(Command.GRIPPERVAL, value)
    bench.step()


def place(bench: MicrocontrollerBench) -> tuple[float, float]:
    gripper = bench.body.gripper
    assert gripper is not None
    return gripper.state.opening, gripper.state.lift


def told(bench: MicrocontrollerBench) -> list[list[float]]:
    gripper = bench.body.gripper
    assert gripper is not None
    return [list(each) for each in gripper.told]


def test_a_robot_without_gripper_says_so(bench_of: BenchOf) -> None:
    bench = bench_of("p3dx-sh").connect()
    bench.send(Command.GRIPREQUEST, 1)
    assert bench.packets(GripperReport, 0.3) == [GripperReport(0, 0, 0.0)]
    order(bench, GripperOrder.OPEN)
    sip = bench.sip()
    assert (sip.gripper_state, sip.analog_port, sip.digital_in) == (0, 0, 0xFF)
    bench.send(Command.CONFIG)
    assert bench.packets(Configuration, 0.3)[0].gripper == 0


@pytest.mark.parametrize(("wiring", "kind"), [("pioneer", 1), ("peoplebot", 2)])
def test_a_gripper_is_reported_by_its_kind_as_often_as_asked(wiring: str, kind: int, make: MakeGripper) -> None:
    bench = make(wiring)
    bench.send(Command.GRIPREQUEST, 2)
    reports = bench.packets(GripperReport, 1.0)
    assert 9 <= len(reports) <= 10
    assert set(reports) == {GripperReport(kind, UNKNOWN, 0.2)}
    bench.send(Command.GRIPREQUEST, 0)
    bench.run(0.1)
    assert bench.packets(GripperReport, 0.5) == []
    bench.send(Command.CONFIG)
    assert bench.packets(Configuration, 0.3)[0].gripper == kind


def test_a_gripperpac_is_type_kind_state_and_grasp_time_in_20_ms(make: MakeGripper) -> None:
    bench = make()
    bench.send(Command.GRIPREQUEST, 1)
    payloads = [sent.payload for sent in bench.run(0.3) if sent.payload[0] == 0xE0]
    assert payloads == [bytes.fromhex("E0 01 33 0A")]


def test_after_power_on_nobody_knows_where_paddles_and_lift_are(make: MakeGripper) -> None:
    bench = make()
    assert bench.sip().gripper_state == UNKNOWN
    order(bench, GripperOrder.DEPLOY)
    assert bench.sip().gripper_state == OPEN | DOWN
    bench.controller.power_cycle()
    bench.run(0.1)
    assert bench.connect().sip().gripper_state == UNKNOWN


def test_paddles_close_and_open_and_say_that_they_move(make: MakeGripper) -> None:
    bench = make()
    order(bench, GripperOrder.CLOSE)
    assert bench.sip().gripper_state & 0x0F == PADDLES_MOVING
    bench.run(2.5)
    assert bench.sip().gripper_state & 0x0F == CLOSED
    assert place(bench)[0] == pytest.approx(0.0, abs=0.02)
    order(bench, GripperOrder.OPEN)
    assert bench.sip().gripper_state & 0x0F == PADDLES_MOVING
    bench.run(2.5)
    assert bench.sip().gripper_state & 0x0F == OPEN
    assert place(bench)[0] == pytest.approx(1.0, abs=0.02)


@pytest.mark.parametrize("grasp", [None, 1, 50, 100])
def test_closing_stops_when_both_paddles_have_pressed_for_the_grasp_time(grasp: int | None, make: MakeGripper) -> None:
    bench = make(thing=0.5)
    if grasp is not None:
        order(bench, GripperOrder.PRESS, value=grasp)
    order(bench, GripperOrder.CLOSE)
    steps = 0
    while told(bench)[-1] != [0, 0]:
        bench.step()
        steps += 1
    closing = 0.5 * 2.0
    assert steps * STEP == pytest.approx(closing + 0.02 * (grasp or 10), abs=3 * STEP)
    assert bench.sip().gripper_state & 0x0F == CLOSED


@pytest.mark.parametrize("grasp", [0, 101, -5])
def test_a_grasp_time_out_of_range_changes_nothing(grasp: int, make: MakeGripper) -> None:
    bench = make()
    order(bench, GripperOrder.PRESS, value=grasp)
    bench.send(Command.GRIPREQUEST, 1)
    assert bench.packets(GripperReport, 0.3)[0].grasp_time == 0.2


def test_the_lift_goes_up_and_down(make: MakeGripper) -> None:
    bench = make()
    order(bench, GripperOrder.UP)
    assert bench.sip().gripper_state & 0xF0 == LIFT_MOVING
    bench.run(4.0)
    assert bench.sip().gripper_state & 0xF0 == UP
    order(bench, GripperOrder.DOWN)
    bench.run(4.0)
    assert bench.sip().gripper_state & 0xF0 == DOWN


def test_carry_moves_the_lift_for_a_time(make: MakeGripper) -> None:
    bench = make()
    order(bench, GripperOrder.CARRY, value=100)
    bench.run(3.0)
    assert place(bench)[1] == pytest.approx(2.0 / 3.5, abs=0.01)
    assert bench.sip().gripper_state & 0xF0 == 0
    order(bench, GripperOrder.CARRY, value=-50)
    bench.run(3.0)
    assert place(bench)[1] == pytest.approx(1.0 / 3.5, abs=0.01)
    order(bench, GripperOrder.CARRY, value=-255)
    bench.run(3.0)
    assert bench.sip().gripper_state & 0xF0 == DOWN


def test_a_value_without_its_order_means_nothing(make: MakeGripper) -> None:
    bench = make()
    order(bench, value=100)
    order(bench, GripperOrder.CARRY, GripperOrder.STOP, value=100)
    bench.run(1.0)
    assert place(bench) == (1.0, 0.0)


def test_store_closes_and_lifts_and_deploy_lowers_and_opens(make: MakeGripper) -> None:
    bench = make()
    order(bench, GripperOrder.STORE)
    bench.run(5.0)
    assert bench.sip().gripper_state == CLOSED | UP
    order(bench, GripperOrder.DEPLOY)
    bench.run(5.0)
    assert bench.sip().gripper_state == OPEN | DOWN


@pytest.mark.parametrize(
    ("stop", "moving"),
    [(GripperOrder.STOP, LIFT_MOVING), (GripperOrder.LIFT_STOP, PADDLES_MOVING), (GripperOrder.HALT, 0)],
)
def test_paddles_and_lift_stop_on_their_way(stop: GripperOrder, moving: int, make: MakeGripper) -> None:
    bench = make()
    order(bench, GripperOrder.STORE)
    bench.run(1.0)
    order(bench, stop)
    assert bench.sip().gripper_state == moving


def test_a_motion_that_does_not_end_is_an_error_until_the_next(make: MakeGripper) -> None:
    bench = make()
    gripper = bench.body.gripper
    assert gripper is not None
    gripper.stuck = True
    order(bench, GripperOrder.STORE)
    bench.run(9.0)
    assert bench.sip().gripper_state == PADDLES_ERROR | LIFT_ERROR
    assert told(bench)[-1] == [0, 0]
    gripper.stuck = False
    order(bench, GripperOrder.DEPLOY)
    bench.run(0.1)
    assert bench.sip().gripper_state == OPEN | DOWN


def test_the_state_byte_stands_in_both_places_where_clients_look(make: MakeGripper) -> None:
    bench = make()
    order(bench, GripperOrder.DEPLOY)
    payload = next(sent.payload for sent in bench.run(0.2) if sent.payload[0] in (0x32, 0x33))
    tail = 20 + 3 * payload[19]
    assert payload[tail : tail + 2] == bytes([OPEN | DOWN] * 2)


def test_switches_and_beams_are_on_the_user_inputs(make: MakeGripper) -> None:
    bench = make(thing=0.5)
    order(bench, GripperOrder.CLOSE)
    bench.run(0.5)
    order(bench, GripperOrder.CARRY, value=50)
    halfway = bench.sips(1.3)[-1].digital_in
    assert halfway & 0x3F == 0b00_1111  # both beams obstructed, both paddles in contact, lift and grip between limits
    bare = make()
    assert bare.sip().digital_in == 0b1111_0000  # open and down: both limits; beams clear, no contact; pins 6, 7 open
    order(bare, GripperOrder.CLOSE)
    bare.run(0.5)
    order(bare, GripperOrder.CARRY, value=50)
    assert bare.sips(0.5)[-1].digital_in & 0x3F == 0b11_0011  # the manual's idle pattern
    bare.send(Command.IOREQUEST, 1)
    assert bare.packets(IoReport, 0.3)[0].digital_in[0] & 0x3F == 0b11_0011


def test_a_peoplebots_switches_are_in_the_second_byte_and_its_user_inputs_stay_free(make: MakeGripper) -> None:
    bench = make("peoplebot", "peoplebot-sh", thing=0.5)
    order(bench, GripperOrder.CLOSE)
    sip = bench.sips(0.5)[-1]
    assert sip.gripper_state & 0x0F == PADDLES_MOVING
    assert sip.analog_port == 0b1011_1101  # paddles moving, no contact, both beams, lift at its limit
    assert sip.digital_in == 0xFF
    order(bench, GripperOrder.CARRY, value=100)
    assert bench.sips(0.5)[-1].analog_port & 0b1100_0000 == 0b1100_0000


def test_closing_the_connection_halts_the_gripper(make: MakeGripper) -> None:
    bench = make()
    order(bench, GripperOrder.UP)
    bench.run(1.0)
    bench.send(Command.CLOSE)
    bench.run(0.1)
    before = place(bench)
    bench.run(1.0)
    assert place(bench) == before


def test_a_reset_stops_a_gripper_on_its_way(make: MakeGripper) -> None:
    bench = make()
    order(bench, GripperOrder.CLOSE, GripperOrder.UP)
    bench.run(0.5)
    bench.controller.power_cycle()
    bench.step()
    stood = place(bench)
    bench.run(1.0)
    assert place(bench) == stood


def test_a_gripper_that_is_wired_and_not_there_ends_in_an_error(bench_of: BenchOf) -> None:
    bench = bench_of("p3dx-sh")
    gripper = gripper_of(Fit({"gripper": "pioneer"}))
    assert gripper is not None
    bench.controller.board.gripper.fit(gripper)
    order(bench.connect(), GripperOrder.UP)
    bench.run(9.0)
    assert bench.sip().gripper_state & LIFT_ERROR


@given(st.lists(st.tuples(st.booleans(), st.integers(-0x8000, 0x7FFF)), max_size=20))
def test_no_order_and_no_value_upsets_the_server(orders: list[tuple[bool, int]]) -> None:
    model = gripper_of(Fit({"gripper": "pioneer"}))
    assert model is not None
    server = GripperServer()
    server.fit(model)
    gripper = PlainGripper(thing=0.3)
    for is_order, number in orders:
        (server.order if is_order else server.value)(number)
        for _ in range(20):
            server.advance(gripper, STEP)
            gripper.step(STEP)
        assert 0 <= server.state <= 0xFF
        assert 0 <= server.inputs <= 0xFF

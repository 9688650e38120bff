"""The emulated modules in virtual time, on an arm whose joints follow at once unless something holds them."""

from dataclasses import replace
from math import radians

import pytest

from configs import load
from p2os.accessories.arm_model import ArmModel
from p2os.accessories.powercube import (
    EVERY_MODULE,
    CubeCommand,
    CubeState,
    ModuleOutcome,
    ModuleParameter,
    ModuleReply,
    ModuleRequest,
    ModuleTelegramDecoder,
    MotionKind,
)
from p2os_emu.accessories.powercube import PowerCubeArm
from tests.p2os_emu.microcontroller.bench import STEP, PlainArm

RAMP = MotionKind.RAMP_ACKNOWLEDGED


class Bench:
    """Modules and a host. heard: answers, with their module. fastest: rad/s or m/s of each joint so far."""

    def __init__(self, model: ArmModel) -> None:
        self.arm = PlainArm(len(model.joints) + 1)
        self.device = PowerCubeArm(model, self.arm)
        self.heard: list[tuple[int, ModuleReply]] = []
        self.fastest = [0.0] * len(self.arm.positions)
        self._decoder = ModuleTelegramDecoder()

    def run(self, seconds: float, *, host: bool = True) -> None:
        """Let time pass, with a host that goes on asking or without."""
        for step in range(round(seconds / STEP)):
            if host and step % 12 == 0:
                self.device.receive(ModuleRequest(CubeCommand.GET, ModuleParameter.VELOCITY).encode(1))
            before = list(self.arm.positions)
            for telegram in self._decoder.receive(self.device.step(STEP)):
                reply = ModuleReply.decode(telegram.data)
                if (reply.command, reply.about) != (CubeCommand.GET, ModuleParameter.VELOCITY):
                    self.heard.append((telegram.module, reply))
            moved = (abs(now - then) / STEP for now, then in zip(self.arm.positions, before, strict=True))
            self.fastest = [max(pair) for pair in zip(self.fastest, moved, strict=True)]

    def ask(self, module: int, request: ModuleRequest) -> ModuleReply:
        """What a module answers."""
        self.device.receive(request.encode(module))
        self.run(STEP)
        number, reply = self.heard[-1]
        assert number == module
        return reply

    def tell_all(self, command: CubeCommand) -> None:
        self.device.receive(ModuleRequest(command).encode(EVERY_MODULE))

    def state(self, module: int) -> CubeState:
        state = self.ask(module, ModuleRequest(CubeCommand.GET, ModuleParameter.STATE)).state
        assert state is not None
        return state

    def homed(self) -> "Bench":
        self.tell_all(CubeCommand.HOME)
        self.run(0.5)
        return self


@pytest.fixture
def model() -> ArmModel:
    return load(ArmModel, "accessories", "powercube-arm")


@pytest.fixture
def bench(model: ArmModel) -> Bench:
    return Bench(model)


def test_arm_that_is_not_made_of_modules_is_refused(model: ArmModel) -> None:
    with pytest.raises(ValueError, match="not made of modules"):
        PowerCubeArm(replace(model, cubes=None), PlainArm(8))


def test_modules_wake_up_on_their_brakes_without_knowing_where_they_are(bench: Bench) -> None:
    assert [bench.state(module) for module in range(1, 9)] == [CubeState.BRAKED] * 8
    assert bench.arm.braked == set(range(8))
    assert bench.ask(2, ModuleRequest(CubeCommand.MOVE, RAMP, 0.5)).outcome is ModuleOutcome.REFUSED


def test_modules_say_what_the_arms_file_says(bench: Bench) -> None:
    values = {
        (2, ModuleParameter.MINIMUM): radians(-100),
        (2, ModuleParameter.MAXIMUM): radians(100),
        (7, ModuleParameter.MAXIMUM): radians(170),
        (8, ModuleParameter.MAXIMUM): 0.07,
        (3, ModuleParameter.MOST_VELOCITY): radians(60),
        (3, ModuleParameter.POSITION): 0.0,
        (3, ModuleParameter.MOST_CURRENT): 10.0,
    }
    for (module, parameter), value in values.items():
        assert bench.ask(module, ModuleRequest(CubeCommand.GET, parameter)).value == pytest.approx(value, abs=1e-6)
    assert bench.ask(3, ModuleRequest(CubeCommand.GET, 0x99)).outcome is ModuleOutcome.REFUSED


def test_home_finds_the_zero_and_everyone_may_be_told_at_once(bench: Bench) -> None:
    bench.arm.positions[2] = 0.3
    bench.tell_all(CubeCommand.HOME)
    bench.run(3.0)
    assert bench.arm.positions == pytest.approx([0.0] * 8)
    assert [bench.state(module) for module in range(1, 9)] == [CubeState.HOMED] * 8


@pytest.mark.parametrize("kind", [MotionKind.RAMP, MotionKind.RAMP_ACKNOWLEDGED])
def test_ramp_gets_there_no_faster_than_it_was_told(bench: Bench, kind: MotionKind) -> None:
    bench.homed()
    assert (
        bench.ask(2, ModuleRequest(CubeCommand.SET, ModuleParameter.RAMP_VELOCITY, 0.5)).outcome is ModuleOutcome.DONE
    )
    reply = bench.ask(2, ModuleRequest(CubeCommand.MOVE, kind, 1.0))
    assert (reply.state is None) == (kind is MotionKind.RAMP)
    bench.run(3.5)
    assert bench.arm.positions[1] == pytest.approx(1.0)
    assert bench.fastest[1] == pytest.approx(0.5, rel=0.01)
    assert bench.state(2) == CubeState.HOMED


def test_step_takes_the_time_it_was_given(bench: Bench) -> None:
    bench.homed()
    bench.ask(1, ModuleRequest(CubeCommand.MOVE, MotionKind.STEP_ACKNOWLEDGED, 0.6, 2.0))
    assert bench.fastest[0] < 0.35
    bench.run(2.7)
    assert bench.arm.positions[0] == pytest.approx(0.6)
    assert bench.fastest[0] == pytest.approx(0.3, rel=0.01)


def test_velocity_goes_on_until_the_end_or_until_it_is_told_zero(bench: Bench) -> None:
    bench.homed()
    bench.ask(6, ModuleRequest(CubeCommand.MOVE, MotionKind.VELOCITY_ACKNOWLEDGED, -0.8))
    bench.run(1.0)
    bench.ask(6, ModuleRequest(CubeCommand.MOVE, MotionKind.VELOCITY_ACKNOWLEDGED, 0.0))
    bench.run(1.5)
    stood = bench.arm.positions[5]
    assert -1.2 < stood < -0.4
    bench.ask(6, ModuleRequest(CubeCommand.MOVE, MotionKind.VELOCITY_ACKNOWLEDGED, -1.0))
    bench.run(4.0)
    assert bench.arm.positions[5] == pytest.approx(radians(-110), abs=1e-3)
    assert bench.state(6) == CubeState.HOMED


@pytest.mark.parametrize(
    ("module", "request_"),
    [
        (2, ModuleRequest(CubeCommand.MOVE, RAMP, radians(101))),
        (2, ModuleRequest(CubeCommand.MOVE, RAMP, radians(-101))),
        (8, ModuleRequest(CubeCommand.MOVE, RAMP, 0.08)),
        (8, ModuleRequest(CubeCommand.MOVE, RAMP, -0.01)),
        (1, ModuleRequest(CubeCommand.MOVE, RAMP, float("nan"))),
        (1, ModuleRequest(CubeCommand.MOVE, MotionKind.VELOCITY_ACKNOWLEDGED, radians(61))),
        (1, ModuleRequest(CubeCommand.MOVE, 0x99, 0.1)),
        (1, ModuleRequest(CubeCommand.SET, ModuleParameter.RAMP_VELOCITY, -1.0)),
        (1, ModuleRequest(CubeCommand.SET, ModuleParameter.MAXIMUM, 9.0)),
        (1, ModuleRequest(0x77)),
    ],
)
def test_what_is_out_of_range_or_unknown_is_refused_and_moves_nothing(
    bench: Bench, module: int, request_: ModuleRequest
) -> None:
    bench.homed()
    assert bench.ask(module, request_).outcome is ModuleOutcome.REFUSED
    bench.run(0.5)
    assert bench.fastest == [0.0] * 8


def test_halt_stops_at_once_and_holds_until_reset(bench: Bench) -> None:
    bench.homed()
    bench.ask(2, ModuleRequest(CubeCommand.MOVE, RAMP, 1.5))
    bench.run(1.0)
    bench.tell_all(CubeCommand.HALT)
    stood = bench.arm.positions[1]
    bench.run(1.0)
    assert bench.arm.positions[1] == stood
    assert 1 in bench.arm.braked
    assert bench.state(2) == CubeState.HOMED | CubeState.HALTED | CubeState.BRAKED
    assert bench.ask(2, ModuleRequest(CubeCommand.MOVE, RAMP, 0.0)).outcome is ModuleOutcome.REFUSED
    assert bench.ask(2, ModuleRequest(CubeCommand.HOME)).outcome is ModuleOutcome.REFUSED
    bench.ask(2, ModuleRequest(CubeCommand.RESET))
    assert bench.ask(2, ModuleRequest(CubeCommand.MOVE, RAMP, 0.0)).outcome is None
    bench.run(3.0)
    assert bench.arm.positions[1] == pytest.approx(0.0)


def test_moving_module_halts_when_the_host_falls_silent(bench: Bench) -> None:
    bench.homed()
    bench.ask(2, ModuleRequest(CubeCommand.MOVE, RAMP, 1.5))
    bench.run(0.9, host=False)
    assert 1 not in bench.arm.braked
    bench.run(0.2, host=False)
    assert 1 in bench.arm.braked
    halted = CubeState.ERROR | CubeState.HALTED | CubeState.SILENCE
    assert bench.state(2) & halted == halted
    assert bench.state(3) == CubeState.HOMED  # it stood


def test_joint_that_cannot_follow_halts_with_an_error(bench: Bench) -> None:
    bench.homed()
    bench.arm.held.add(3)
    bench.ask(4, ModuleRequest(CubeCommand.MOVE, RAMP, 1.5))
    bench.run(2.0)
    assert bench.state(4) & ~CubeState.HOMED == (CubeState.ERROR | CubeState.HALTED | CubeState.LAGS | CubeState.BRAKED)


def test_modules_that_are_not_there_and_damaged_telegrams_get_no_answer(bench: Bench) -> None:
    wire = bytearray(ModuleRequest(CubeCommand.HOME).encode(1))
    wire[3] ^= 0x40
    for data in (bytes(wire), ModuleRequest(CubeCommand.HOME).encode(9), b"\x02\x10\x03noise"):
        bench.device.receive(data)
        assert bench.device.step(STEP) == b""


def test_arm_that_stands_costs_its_body_nothing(bench: Bench) -> None:
    bench.homed()
    told = bench.arm.told
    bench.run(1.0)
    assert bench.arm.told == told

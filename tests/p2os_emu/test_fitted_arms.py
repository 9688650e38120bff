"""Arms as they are fitted to an emulated robot: from bytes on its lines to joints in the world."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from math import radians

import pytest

import configs
from p2os import Command, RobotModel, encode_command
from p2os.accessories.powercube import (
    CubeCommand,
    CubeState,
    ModuleParameter,
    ModuleRequest,
    MotionKind,
)
from p2os_emu.accessories.powercube import PowerCubeArm
from p2os_emu.emulator import STEP, Emulator
from p2os_emu.fit import FitError, read_fit
from p2os_emu.links.line import LinkProfile
from p2os_emu.links.memory import MemoryLink
from p2os_emu.world import World, WorldSpec
from tests.p2os_emu.flat_world import FlatWorld

IDEAL = configs.load(LinkProfile, "links", "ideal")


@dataclass
class Rig:
    """One robot with an arm, and clients on both its lines."""

    world: World | FlatWorld
    model: str
    link: MemoryLink = field(default_factory=MemoryLink)
    cable: MemoryLink = field(default_factory=MemoryLink)

    def __post_init__(self) -> None:
        model, fit = read_fit(["arm"], configs.load(RobotModel, "robots", self.model))
        self.emulator = Emulator(self.world, IDEAL)
        self.robot = self.emulator.add("happy", model, self.link, fit=fit, cables={"arm": self.cable})

    def run(self, seconds: float, each: Callable[[], None] = lambda: None) -> None:
        for step in range(round(seconds / STEP)):
            if step % 24 == 0:
                each()
            self.emulator.step()

    def tell(self, command: Command, value: float | tuple[int, int] | None = None) -> None:
        self.link.client_write(encode_command(command, value))

    def pulse(self) -> None:
        self.tell(Command.PULSE)

    def ask(self, module: int, request: ModuleRequest) -> None:
        self.cable.client_write(request.encode(module))

    def poll(self) -> None:
        self.ask(1, ModuleRequest(CubeCommand.GET, ModuleParameter.STATE))

    @property
    def positions(self) -> list[float]:
        arm = self.robot.body.arm
        assert arm is not None
        return list(arm.positions)


@pytest.fixture
def make_rig() -> Iterator[Callable[[str], Rig]]:
    worlds: list[World] = []

    def make(model: str) -> Rig:
        worlds.append(World(WorldSpec("floor"), perfect=True))
        return Rig(worlds[-1], model)

    yield make
    for world in worlds:
        world.close()


MakeRig = Callable[[str], Rig]


def test_pioneers_commands_turn_its_joints_and_a_lost_client_brings_them_home(make_rig: MakeRig) -> None:
    rig = make_rig("p3dx")
    for number in range(3):
        rig.link.client_write(bytes.fromhex(f"FA FB 03 0{number} 00 0{number}"))
        rig.run(0.05)
    rig.tell(Command.OPEN)
    rig.tell(Command.ARM_POWER, 1)
    rig.run(2.2, rig.pulse)
    rig.tell(Command.ARM_POS, (2, 128))  # its zero: level, from upright
    rig.tell(Command.ARM_POS, (6, 128))
    rig.run(2.5, rig.pulse)
    assert rig.positions[1] == pytest.approx(0.0, abs=radians(1))
    assert rig.positions[5] == pytest.approx(0.025, abs=0.001)
    rig.run(5.0)
    assert rig.positions[1] == pytest.approx(radians(90), abs=radians(1))
    assert rig.positions[5] == pytest.approx(0.0, abs=0.001)


def test_powerbots_modules_turn_its_joints_and_power_that_fails_puts_the_brakes_on(make_rig: MakeRig) -> None:
    rig = make_rig("powerbot")
    rig.ask(0, ModuleRequest(CubeCommand.HOME))
    rig.run(0.5, rig.poll)
    rig.ask(2, ModuleRequest(CubeCommand.MOVE, MotionKind.RAMP_ACKNOWLEDGED, 1.2))
    rig.run(1.0, rig.poll)
    rig.robot.power_off()
    rig.run(0.5)
    stood = rig.positions[1]
    assert 0.2 < stood < 1.0
    rig.run(1.0)
    rig.robot.power_on()
    rig.run(1.0, rig.poll)
    assert rig.positions[1] == pytest.approx(stood, abs=radians(1))
    device = rig.robot.cables["arm"].device
    assert isinstance(device, PowerCubeArm)
    assert device.cubes[1].state == CubeState.BRAKED


def test_world_without_joints_takes_no_arm_of_modules() -> None:
    with pytest.raises(FitError, match="no joints"):
        Rig(FlatWorld(), "powerbot")

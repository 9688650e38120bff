"""Camera head and camera through everything there is: firmware, driver, cable, processes, Zenoh."""

from collections.abc import Callable
from math import degrees
from typing import TYPE_CHECKING, Any

import pytest

from acromovi.children import emulator, gateway
from bus import Bus, Sample, keys, messages
from cameras import picture_size
from configs import load
from gateway.elements.ptz.element import PtzElement
from gateway.errors import CommandRefused
from gateway.events import HeadSeen
from p2os.accessories.head_model import HeadModel
from p2os_emu.accessories.evid30 import EviD30
from p2os_emu.accessories.vcc4 import Vcc4

if TYPE_CHECKING:
    from tests.gateway.conftest import MakeBench


@pytest.mark.parametrize(("kind", "name"), [(Vcc4, "vcc4"), (EviD30, "evid30")])
@pytest.mark.parametrize("baud", [9600, 115200])
def test_head_is_steered_through_the_firmware_while_the_robot_drives(
    make_bench: "MakeBench", kind: type[Vcc4 | EviD30], name: str, baud: int
) -> None:
    bench = make_bench("p3dx-sh", rates=(baud,))
    head = kind(load(HeadModel, "accessories", name))
    bench.robot.board.plug(1, lambda: head)
    bench.connect()
    bench.run_until(lambda: bench.driver.has(PtzElement))
    bench.run(5.0)
    bench.driver.element(PtzElement, bench.now).look(0.5, -0.2, None, bench.now)
    began = bench.now

    def drive() -> None:
        bench.driver.set_velocity(0.2, 0.0, bench.now)

    bench.run(3.0, drive)
    assert degrees(head.head.pan.position) == pytest.approx(degrees(0.5), abs=0.1)
    seen = bench.of(HeadSeen, began)
    assert sum(event.moving for event in seen) >= 4
    assert not seen[-1].moving
    assert (seen[-1].pan, seen[-1].tilt) == pytest.approx((0.5, -0.2), abs=0.002)
    assert bench.body.is_turning()
    assert len(bench.raw) < 0.5 * 960 * (bench.now - 100.0)  # bytes: half of what 9600 bit/s carry in that time


def test_robot_without_a_head_refuses_to_look(make_bench: "MakeBench") -> None:
    bench = make_bench("p3dx-sh")
    bench.connect()
    bench.run(3.0)
    with pytest.raises(CommandRefused, match="this robot has no ptz"):
        bench.driver.element(PtzElement, bench.now)


def test_pictures_and_head_are_on_the_bus_and_the_head_turns_when_asked(
    robot: str, bus: Bus, until: Callable[..., None]
) -> None:
    pictures: list[bytes] = []
    places: list[Any] = []

    def on_picture(sample: Sample) -> None:
        pictures.append(messages.decode(keys.CAMERA.type_name, sample.payload).data.tobytes())

    def on_place(sample: Sample) -> None:
        places.append(messages.decode(keys.PTZ.type_name, sample.payload))

    bus.subscribe(keys.CAMERA.key(robot), on_picture)
    bus.subscribe(keys.PTZ.key(robot), on_place)
    fit = ("--robot", f"p3dx-sh:{robot}", "--fit", "ptz:evid30,camera:64x48@10", "--world", "empty")
    with emulator(*fit) as robots, gateway(robots.port, "--quiet", "--camera", robots.robots[0]["camera_url"]):
        until(lambda: len(pictures) >= 3 and places)
        assert picture_size(pictures[-1]) == (64, 48)
        [answer] = bus.query(keys.LOOK.key(robot), {"pan": 0.4})
        assert answer.value == {"accepted": True}
        until(lambda: places[-1].pan == pytest.approx(0.4, abs=0.01) and not places[-1].moving)
        [described] = bus.query(keys.DESCRIPTION.key(robot), {})
        elements = {element["name"]: element for element in described.value["elements"]}
        assert elements["ptz"]["model"] == "Sony EVI-D30"
        assert elements["camera"]["size"] == [64, 48]

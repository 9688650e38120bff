"""The face and the components agree: on what readings hold, and on what can be asked for."""

import base64
import math
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from agents import RobotError, Team
from agents.client.readings import OtherReading
from agents.client.robot import ELEMENTS
from agents.client.sensors import Picture
from agents.components.all_components import COMPONENTS, component_for
from agents.platform import AgentName
from tests.agents.client.conftest import Part, World

READ = sorted(name for name in ELEMENTS.keys() & COMPONENTS if ELEMENTS[name].reading is not OtherReading)
LISTS = ("front", "rear", "digital_in", "digital_out", "analog_in", "axes", "buttons")
RANGES: dict[str, Any] = {"laser": [None], "sonar": {"3": None}, "ir": {"3": None}}
CALLS: dict[str, list[Callable[[Any], object]]] = {
    "base": [
        lambda base: base.move(1.0),
        lambda base: base.move(1.0, speed=0.2),
        lambda base: base.turn(1.0),
        lambda base: base.heading(1.0),
        lambda base: base.go_to(1.0, 2.0),
        lambda base: base.go_to(1.0, 2.0, heading=0.5, speed=0.2),
        lambda base: base.drive(0.2, 0.1, seconds=0.1),
        lambda base: base.drive(0.2),
        lambda base: base.stop(),
        lambda base: base.enable(),
        lambda base: base.estop(),
    ],
    "sonar": [lambda sonar: sonar.power(False)],
    "io": [lambda io: io.output(1, 1)],
    "gripper": [
        lambda gripper: gripper.open(),
        lambda gripper: gripper.close(),
        lambda gripper: gripper.up(),
        lambda gripper: gripper.down(),
        lambda gripper: gripper.store(),
        lambda gripper: gripper.deploy(),
        lambda gripper: gripper.stop(),
    ],
    "arm": [
        lambda arm: arm.move({"1": 0.5}),
        lambda arm: arm.move({1: 0.5}),
        lambda arm: arm.move({np.int64(1): np.float32(0.5)}),
        lambda arm: arm.move({"1": 0.5}, speed=0.3),
        lambda arm: arm.reach(0.45, 0.0, 0.3),
        lambda arm: arm.reach(0.45, 0.0, 0.3, speed=0.2),
        lambda arm: arm.home(),
        lambda arm: arm.park(),
        lambda arm: arm.power(),
        lambda arm: arm.stop(),
    ],
    "ptz": [lambda ptz: ptz.look(pan=0.5, zoom=2.0), lambda ptz: ptz.centre(), lambda ptz: ptz.stop()],
    "sound": [lambda sound: sound.play([(60, 0.2)]), lambda sound: sound.play(3), lambda sound: sound.mute()],
    "joystick": [lambda joystick: joystick.drive()],
}


def result_of(element: str) -> dict[str, Any]:
    """What a component says when it knows nothing but that it is there."""
    rows = {**{name: [None] for name in LISTS}, "ranges": RANGES.get(element), "joints": {"1": None}}
    return {"stamp": 1.5, **{name: rows.get(name) for name in told_by(element)}}


def told_by(element: str) -> list[str]:
    """The names in a component's results, besides the stamp."""
    return ", ".join(COMPONENTS[element].results).split(", ")


@pytest.mark.parametrize("element", READ)
def test_a_reading_has_the_fields_that_its_component_tells(element: str) -> None:
    told = {each.name for each in fields(ELEMENTS[element].reading) if not each.metadata.get("described")}
    assert told == {"stamp", *told_by(element)}


@pytest.mark.parametrize("element", READ)
def test_what_is_not_known_can_be_read_all_the_same(element: str) -> None:
    reading = ELEMENTS[element].reading.of(result_of(element), element)
    numbers = {each.name: getattr(reading, each.name) for each in fields(reading) if each.type is float}
    assert numbers.pop("stamp") == 1.5
    assert not any(map(math.isfinite, numbers.values()))


@pytest.mark.parametrize("element", CALLS)
def test_components_understand_what_the_face_asks_for(world: World, element: str) -> None:
    world.add(component_for(element)(AgentName(element, "doc")))
    with world.team() as team:
        part = team.robot("doc").element(element)
        for call in CALLS[element]:
            with pytest.raises(RobotError) as caught:  # nobody drives the robot
                call(part)
            told = str(caught.value)
            assert "understand" not in told
            assert "arguments" not in told


def test_a_picture_is_a_file_or_pixels(world: World, team: Team, tmp_path: Path) -> None:
    blue = np.zeros((4, 6, 3), np.uint8)
    blue[:, :, 0] = 255
    _, png = cv2.imencode(".png", blue)
    given = {"format": "png", "width": 6, "height": 4, "data": base64.b64encode(png.tobytes()).decode()}
    camera = Part("camera@happy")
    camera.answer("picture", lambda: given)
    world.add(camera)
    picture = team.robot("happy").camera.picture()
    assert (picture.width, picture.height) == (6, 4)
    assert picture.pixels().tolist() == blue.tolist()
    assert "stamp" not in repr(picture)
    picture.save(tmp_path / "here.png")
    assert (tmp_path / "here.png").read_bytes() == png.tobytes()
    with pytest.raises(RobotError, match=r"cannot be written to .*: No such file or directory"):
        picture.save(tmp_path / "nowhere" / "here.png")


def test_a_picture_is_shown_by_its_size_and_stamp(world: World, team: Team) -> None:
    data = bytes(10_400)
    given = {
        "stamp": 1793404800.5,
        "format": "jpeg",
        "width": 320,
        "height": 240,
        "data": base64.b64encode(data).decode(),
    }
    camera = Part("camera@happy")
    camera.answer("picture", lambda: given)
    world.add(camera)
    picture = team.robot("happy").camera.picture()
    assert picture.stamp == 1793404800.5
    assert repr(picture) == "<Picture jpeg, 320 x 240 pixels, 10.4 kB, stamp 1793404800.500>"
    assert str(picture) == repr(picture)
    assert repr(Picture(format="png", width=None, height=None, data=b"")) == "<Picture png, unknown size, 0.0 kB>"


DISCS = [
    {"number": number, "x": 0.1, "y": 0.0, "heading": math.radians(heading), "frame": f"happy/sonar_{number}"}
    for number, heading in enumerate((90, 50, 30, 10, -10, -30, -50, -90, 180))
]


@pytest.fixture
def sonar(world: World, team: Team) -> Any:
    """Discs as on a Pioneer, each at 1 m and as many cm as its number; disc 8 points to the rear and has no echo."""
    ranges = {str(number): 1.0 + number / 100 for number in range(8)} | {"8": None}
    part = Part("sonar@happy", {"ranges": ranges, "nearest": 1.0, "bearing": math.pi / 2})
    part.properties["discs"] = [{**each, "field_of_view": math.radians(15)} for each in DISCS]
    world.add(part)
    return team.robot("happy").sonar


def test_the_sonar_says_where_its_discs_point(sonar: Any) -> None:
    disc = sonar.discs[3]
    assert (disc.number, disc.frame, disc.x, disc.y) == (3, "happy/sonar_3", 0.1, 0.0)
    assert disc.heading == pytest.approx(math.radians(10))
    reading = sonar.read()
    assert reading.discs == sonar.discs
    assert reading.ranges == {**{number: 1.0 + number / 100 for number in range(8)}, 8: math.inf}


@pytest.mark.parametrize(
    ("angle", "width", "nearest"),
    [
        (0.0, 0.6, 1.03),  # 17 degrees to each side: the cones at 30 degrees begin at 22.5
        (0.0, 0.9, 1.02),
        (0.0, 0.1, 1.03),
        (math.pi / 2, 0.2, 1.0),
        (-math.pi / 2, 0.2, 1.07),
        (math.pi, 0.5, math.inf),
        (-math.pi, 0.5, math.inf),
        (2 * math.pi, 0.1, 1.03),
        (0.0, 10.0, 1.0),
    ],
)
def test_the_sonar_is_asked_what_is_in_a_sector(sonar: Any, angle: float, width: float, nearest: float) -> None:
    assert sonar.read().within(angle, width) == pytest.approx(nearest)
    assert sonar.within(angle, width) == pytest.approx(nearest)


@pytest.mark.parametrize(
    ("angle", "width", "why"),
    [
        (2.3, 0.1, "no sonar disc points within 0.05 rad of 2.3 rad; discs point to -1.57, -0.873, "),
        (0.3, -0.3, r"takes an angle and a width above 0, rad, not within\(0.3, -0.3\); try within\(0, 0.6\)"),
        (0.0, 0.0, "above 0"),
        (math.nan, 0.1, "above 0"),
        (0.0, math.nan, "above 0"),
    ],
)
def test_a_sector_where_the_sonar_is_blind_is_an_error(sonar: Any, angle: float, width: float, why: str) -> None:
    with pytest.raises(RobotError, match=why):
        sonar.within(angle, width)


def test_numbers_are_keys_as_in_python(world: World, team: Team) -> None:
    world.add(Part("sonar@happy", {"ranges": {"3": 1.2, "4": None}, "nearest": 1.2, "bearing": 0.1}))
    world.add(Part("arm@happy", {"joints": {"1": 0.5, "2": None}, "powered": True, "homed": True, "moving": False}))
    robot = team.robot("happy")
    assert robot.sonar.ask("read")["ranges"] == {3: 1.2, 4: None}
    assert team.ask("sonar@happy", "read")["ranges"] == {3: 1.2, 4: None}
    assert robot.arm.read().joints == {1: 0.5, 2: pytest.approx(math.nan, nan_ok=True)}


@pytest.mark.parametrize(
    "value", [{}, {"1": 2, "x": 3}, {"01": 1}, {"1.0": 1}, {"": 1}, {"-": 1}, {"\u0661": 1}, [1, "2"], "3", None]
)
def test_other_keys_stay_text(world: World, team: Team, value: Any) -> None:
    world.add(Part("sonar@happy", {"value": value}))
    assert team.ask("sonar@happy", "read")["value"] == value


def test_keys_are_numbers_at_any_depth(world: World, team: Team) -> None:
    world.add(Part("sonar@happy", {"value": [{"a": {"-1": {"0": "x"}}}]}))
    assert team.ask("sonar@happy", "read")["value"] == [{"a": {-1: {0: "x"}}}]


def test_what_is_no_picture_is_told() -> None:
    with pytest.raises(RobotError, match="what the camera gave is no jpeg that can be read"):
        Picture(format="jpeg", width=None, height=None, data=b"nothing").pixels()


def test_a_compass_that_does_not_know_says_so(world: World, team: Team) -> None:
    compass = world.add(Part("compass@happy", {"heading": 0.5}))
    assert team.robot("happy").compass.heading() == 0.5
    compass.result["heading"] = None
    assert math.isnan(team.robot("happy").compass.heading())

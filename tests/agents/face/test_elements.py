"""The face and the components agree: on what readings hold, and on what can be asked for."""

import base64
import math
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from agents import RobotError, Team
from agents.components.all_components import COMPONENTS, component_for
from agents.face.picture import Picture
from agents.face.readings import OtherReading
from agents.face.robot import ELEMENTS
from agents.platform import AgentName
from tests.agents.face.conftest import Part, World

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
        lambda arm: arm.move({"1": 0.5}, speed=0.3),
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
    assert {each.name for each in fields(ELEMENTS[element].reading)} == {"stamp", *told_by(element)}


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
    cv2 = pytest.importorskip("cv2", reason="pictures are taken apart by an extra")
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
    picture.save(tmp_path / "here.png")
    assert (tmp_path / "here.png").read_bytes() == png.tobytes()
    with pytest.raises(RobotError, match=r"cannot be written to .*: No such file or directory"):
        picture.save(tmp_path / "nowhere" / "here.png")


def test_what_is_no_picture_is_told() -> None:
    pytest.importorskip("cv2", reason="pictures are taken apart by an extra")
    with pytest.raises(RobotError, match="what the camera gave is no jpeg that can be read"):
        Picture(format="jpeg", width=None, height=None, data=b"nothing").pixels()


def test_a_compass_that_does_not_know_says_so(world: World, team: Team) -> None:
    compass = world.add(Part("compass@happy", {"heading": 0.5}))
    assert team.robot("happy").compass.heading() == 0.5
    compass.result["heading"] = None
    assert math.isnan(team.robot("happy").compass.heading())

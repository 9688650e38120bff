import pytest

import configs
from p2os import RobotModel
from p2os_emu.fit import BARE, FitError, read_fit


def model(name: str) -> RobotModel:
    return configs.load(RobotModel, "robots", name)


def test_parts_are_fitted_in_their_usual_variant_unless_one_is_named() -> None:
    _, fit = read_fit(["gripper", "laser", "ptz:evid30"], model("p3dx-sh"))
    assert fit.parts == {"gripper": "pioneer", "laser": "lms200", "ptz": "evid30"}
    assert fit.has("ptz")
    assert fit.has("ptz", "evid30")
    assert not fit.has("ptz", "vcc4")
    assert not BARE.has("ptz")


@pytest.mark.parametrize(
    ("robot", "arm", "cables"), [("p3dx-sh", "pioneer", ()), ("powerbot-sh", "powercube", ("arm",))]
)
def test_arm_is_the_one_that_goes_onto_the_model(robot: str, arm: str, cables: tuple[str, ...]) -> None:
    _, fit = read_fit(["arm"], model(robot))
    assert (fit.parts["arm"], fit.cables) == (arm, cables)


def test_later_word_wins() -> None:
    _, fit = read_fit(["laser", "gripper", "no-laser"], model("p3dx"))
    assert list(fit.parts) == ["gripper"]


def test_rear_sonar_comes_off_and_the_front_stays() -> None:
    whole = model("p3dx-sh")
    left, _ = read_fit(["no-rear-sonar"], whole)
    assert [disc.number for disc in left.sonar] == [disc.number for disc in whole.sonar if disc.number < 8]
    bare, _ = read_fit(["no-sonar", "no-bumpers"], whole)
    assert (bare.sonar, bare.front_bumpers, bare.rear_bumpers) == ((), 0, 0)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("griper", "did you mean gripper"),
        ("no-rear-sonnar", "rear-sonar"),
        ("ptz:vcc5", "there are vcc4, evid30"),
        ("joystick:big", "there is one kind"),
        ("", "there is no part ''"),
    ],
)
def test_what_there_is_not_is_refused_with_what_there_is(text: str, says: str) -> None:
    with pytest.raises(FitError, match=says):
        read_fit([text], model("p3dx"))


@pytest.mark.parametrize("part", ["gripper", "laser", "ptz", "arm:pioneer", "arm:powercube"])
def test_small_robot_does_not_carry_what_is_too_heavy(part: str) -> None:
    with pytest.raises(FitError, match=r"amigo of 3.6 kg cannot carry .*; fit it to a robot of \d+ kg or more"):
        read_fit([part], model("amigo"))


def test_arm_of_modules_goes_onto_a_powerbot_only() -> None:
    with pytest.raises(FitError, match="p3dx-sh of 9 kg cannot carry arm:powercube"):
        read_fit(["arm:powercube"], model("p3dx-sh"))
    _, fit = read_fit(["arm:powercube", "no-arm"], model("p3dx-sh"))  # thought better of
    assert not fit.has("arm")
    _, fit = read_fit(["arm:powercube"], model("powerbot"))
    assert fit.has("arm", "powercube")

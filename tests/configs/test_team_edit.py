"""The calibration of a camera in a team file: comments and order stay, and a file is never left half written."""

import json
from pathlib import Path

import pytest

from configs import ConfigError
from configs.camera_calibration import CameraCalibration
from configs.team_edit import write_calibration
from configs.team_file import read_team

KNOWN = CameraCalibration(320, 240, 301.5, 300.25, 160.0, 119.5, (-0.2, 0.05, 0.001, -0.0005, 0.0), 0.21)
TEXT = """\
# my team
about = "two robots"

[[robots]]  # the first
name = "happy"
model = "p3dx-sh"
# its camera is on the left

# the second one
[[robots]]
name = "doc"
model = "p3dx-sh"
fit = [
    "laser",  # SICK
    "camera:160x120@10",
]

[services.monitor]
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "mine.toml"
    path.write_text(TEXT, encoding="utf-8")
    return path


def test_one_line_is_added_to_the_robot_and_everything_else_stays(file: Path) -> None:
    file.chmod(0o640)
    for robot in ("doc", "happy"):
        write_calibration(file, robot, KNOWN)
    lines = file.read_text(encoding="utf-8").splitlines()
    added = [at for at, line in enumerate(lines) if line.startswith("camera_calibration = {")]
    assert [line for at, line in enumerate(lines) if at not in added] == TEXT.splitlines()
    assert [lines[at - 1] for at in added] == ['model = "p3dx-sh"', "]"]
    assert [robot.camera_calibration for robot in read_team(str(file)).robots] == [KNOWN, KNOWN]
    assert file.stat().st_mode & 0o777 == 0o640
    assert [each.name for each in file.parent.iterdir()] == ["mine.toml"]


def test_a_new_calibration_replaces_the_old_one(file: Path) -> None:
    write_calibration(file, "happy", CameraCalibration(320, 240, 1.0, 1.0, 1.0, 1.0))
    write_calibration(file, "happy", KNOWN)
    assert file.read_text(encoding="utf-8").count("camera_calibration") == 1
    assert read_team(str(file)).robots[0].camera_calibration == KNOWN


def test_line_ends_of_windows_and_a_last_line_without_an_end_are_kept(file: Path) -> None:
    file.write_bytes(b'[[robots]]\r\nname = "happy"\r\nmodel = "p3dx-sh"')
    write_calibration(file, "happy", KNOWN)
    text = file.read_bytes()
    assert text.startswith(b'[[robots]]\r\nname = "happy"\r\nmodel = "p3dx-sh"\r\ncamera_calibration = {')
    assert b"\n" not in text.replace(b"\r\n", b"")


def test_a_link_to_a_team_file_stays_a_link(file: Path, tmp_path: Path) -> None:
    link = tmp_path / "link.toml"
    link.symlink_to(file)
    write_calibration(link, "happy", KNOWN)
    assert link.is_symlink()
    assert read_team(str(file)).robots[0].camera_calibration == KNOWN


@pytest.mark.parametrize(
    "text",
    [
        'robots = [{ name = "happy", model = "p3dx-sh" }]\n',
        'about = """\n[[robots]]\n"""\n[[robots]]\nname = "happy"\nmodel = "p3dx-sh"\n',
        '[[robots]]\nname = "happy"\nmodel = "p3dx-sh"\n[robots.camera_calibration]\n'
        "width = 1\nheight = 1\nfx = 1.0\nfy = 1.0\ncx = 0.0\ncy = 0.0\n",
    ],
)
def test_a_form_that_cannot_be_edited_is_left_alone_and_the_line_is_told(file: Path, text: str) -> None:
    file.write_text(text, encoding="utf-8")
    with pytest.raises(ConfigError, match=r"add to the robot happy by hand: camera_calibration = \{ width = 320"):
        write_calibration(file, "happy", KNOWN)
    assert file.read_text(encoding="utf-8") == text


def test_a_robot_that_is_not_there_is_told_with_those_that_are(file: Path) -> None:
    with pytest.raises(ConfigError, match="no robot 'grumpy' in this team; its robots are happy, doc"):
        write_calibration(file, "grumpy", KNOWN)


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ({"fx": 0.0}, "fx of a camera's calibration must be above 0"),
        ({"distortion": [0.1]}, "needs 5 values|5 values"),
        ({"focal": 3.0}, "unknown key robots"),
    ],
)
def test_a_calibration_that_cannot_be_is_refused_with_the_team(file: Path, change: dict[str, object], why: str) -> None:
    table = {"width": 320, "height": 240, "fx": 300.0, "fy": 300.0, "cx": 160.0, "cy": 120.0} | change
    pairs = ", ".join(f"{key} = {json.dumps(value)}" for key, value in table.items())
    file.write_text(TEXT.replace('"happy"', f'"happy"\ncamera_calibration = {{ {pairs} }}'), encoding="utf-8")
    with pytest.raises(ConfigError, match=why):
        read_team(str(file))

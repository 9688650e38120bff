"""`acromovi camera calibrate`: from chessboards in files and streams to the team file."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

import agents
import cameras
from acromovi.__main__ import main
from agents import Failed
from agents.client.sensors import Picture
from cameras import CameraLost
from configs.team_file import read_team
from tests.acromovi.team.private_bus import private_bus
from tests.vision.chessboards import CX, CY, FX, FY, HEIGHT, WIDTH, chessboards

TEAM = '# ours\n[[robots]]\nname = "doc"  # with a camera\nmodel = "p3dx-sh"\n'


@pytest.fixture
def views(tmp_path: Path) -> Path:
    """A folder with views of a chessboard, an image without one, and a team file beside."""
    folder = tmp_path / "views"
    folder.mkdir()
    for number, image in enumerate(chessboards()):
        cv2.imwrite(str(folder / f"{number}.png"), image)
    cv2.imwrite(str(folder / "wall.png"), np.full((HEIGHT, WIDTH), 90, np.uint8))
    (tmp_path / "mine.toml").write_text(TEAM, encoding="utf-8")
    return folder


def calibrate(*words: object) -> int:
    return main(["camera", "calibrate", *map(str, words)])


def test_images_become_a_calibration_in_the_team_file(views: Path, capsys: pytest.CaptureFixture[str]) -> None:
    team = views.parent / "mine.toml"
    assert calibrate(views / "*.png", "--into", team, "doc/camera") == 0
    shown = capsys.readouterr()
    assert "9 images of 320 x 240 px, error 0." in shown.out
    assert "1 images not used" in shown.out
    assert f"written into {team} for doc" in shown.out
    assert "wall.png does not show the whole board of 9 x 6 inner corners" in shown.err
    assert team.read_text(encoding="utf-8").startswith(TEAM)
    known = read_team(str(team)).robots[0].camera_calibration
    assert known is not None
    assert (known.width, known.height) == (WIDTH, HEIGHT)
    assert known.fx == pytest.approx(FX, rel=0.01)
    assert known.fy == pytest.approx(FY, rel=0.01)
    assert (known.cx, known.cy) == pytest.approx((CX, CY), rel=0.01)


def test_json_has_the_numbers_and_why_images_are_not_used(views: Path, capsys: pytest.CaptureFixture[str]) -> None:
    images = [views / f"{number}.png" for number in (0, 1, 2, 3, 4, 5, 0)]
    assert calibrate(*images, "--json", "--quiet") == 0
    shown = capsys.readouterr()
    assert shown.err == ""
    told = json.loads(shown.out)
    assert told["fx"] == pytest.approx(FX, rel=0.02)
    assert len(told["distortion"]) == 5
    assert told["used"] == [str(image) for image in images[:6]]
    assert told["not_used"] == {str(images[0]): f"is like {images[0]}"}
    assert told["error_px"] < 0.3


class _Camera:
    """A camera before which a chessboard is held, each view for two images."""

    def __init__(self, where: str) -> None:
        assert where == "http://eye/video"
        self._images = (cv2.imencode(".jpg", image)[1].tobytes() for image in chessboards() for _ in range(2))

    def read(self) -> cameras.CameraPicture:
        """The next image; without more, the camera is gone."""
        try:
            return cameras.CameraPicture(next(self._images))
        except StopIteration:
            raise CameraLost("the camera has closed the connection") from None

    def close(self) -> None:
        """Nothing is held."""


def test_a_live_camera_is_used_until_the_views_suffice(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(cameras, "open_source", _Camera)
    assert calibrate("http://eye/video", "--views", 6, "--json") == 0
    shown = capsys.readouterr()
    told = shown.err.splitlines()
    assert told[0].startswith("0 views; missing: 6 more views (the image shows the board moving; hold it still)")
    assert told[1].startswith("1 views; missing: 5 more views, near the left edge")
    assert told[-1].endswith("views, which suffice")
    assert json.loads(shown.out)["fx"] == pytest.approx(FX, rel=0.02)


class _Team:
    """A team whose robot doc shows each picture for a while: who asks too early gets the same again."""

    def __init__(self, bus: str) -> None:
        assert bus == "local:test"
        self.camera, self.asked, self._eye = self, 0, _Camera("http://eye/video")
        self._data = b""

    def __enter__(self) -> "_Team":
        return self

    def __exit__(self, *error: object) -> None:
        """Nothing is held."""

    def robot(self, name: str, having: str) -> "_Team":
        assert (name, having) == ("doc", "camera")
        return self

    def picture(self) -> Picture:
        self.asked += 1
        if self.asked % 2:
            self._data = self._eye.read().jpeg
        return Picture(format="jpeg", width=WIDTH, height=HEIGHT, data=self._data, stamp=float((self.asked + 1) // 2))

    def sleep(self, seconds: float) -> None:
        assert self.asked % 2 == 0


class _PausingTeam(_Team):
    """Its camera gives no picture now and then, as that of an emulator on a busy machine."""

    def __init__(self, bus: str) -> None:
        super().__init__(bus)
        self.failed = 0

    def picture(self) -> Picture:
        if self.asked % 4 == 2 and self.failed < self.asked:
            self.failed = self.asked
            raise Failed("camera@doc could not picture: camera@doc has heard nothing for 3.0 s")
        return super().picture()


class _DarkTeam(_Team):
    """Its camera never gives a picture."""

    def picture(self) -> Picture:
        raise Failed("camera@doc could not picture: camera@doc has heard nothing for 3.0 s")


def test_a_camera_that_pauses_loses_no_views_and_its_pauses_are_told(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(agents, "Team", _PausingTeam)
    assert calibrate("doc", "--views", 6, "--json", "--bus", "local:test") == 0
    shown = capsys.readouterr()
    assert json.loads(shown.out)["fx"] == pytest.approx(FX, rel=0.02)
    assert "no image comes: camera@doc could not picture: camera@doc has heard nothing for 3.0 s\n" in shown.err


def test_a_time_that_is_over_before_there_are_enough_views_is_told(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(cameras, "open_source", _Camera)
    assert calibrate("http://eye/video", "--timeout", 0.001) == 1
    told = capsys.readouterr().err
    assert "the 0.001 s are over; --timeout gives more\n" in told
    assert "different views of the board of 9 x 6 inner corners were found; take at least 6" in told


def test_a_camera_that_gives_no_picture_at_all_is_told_at_once(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(agents, "Team", _DarkTeam)
    assert calibrate("doc", "--quiet", "--bus", "local:test") == 1
    assert "has heard nothing" in capsys.readouterr().err


@pytest.mark.parametrize("source", ["doc", "doc/camera"])
def test_the_live_camera_of_a_robot_is_used_picture_by_picture(
    source: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(agents, "Team", _Team)
    assert calibrate(source, "--views", 6, "--json", "--quiet", "--bus", "local:test") == 0
    told = json.loads(capsys.readouterr().out)
    assert told["fx"] == pytest.approx(FX, rel=0.02)
    assert told["used"][0] == "image 2"


def test_a_live_camera_that_is_lost_too_early_is_told(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(cameras, "open_source", _Camera)
    assert calibrate("http://eye/video", "--views", 30, "--quiet") == 1
    assert capsys.readouterr().err == "acromovi camera: the camera has closed the connection\n"


def test_a_video_is_calibrated_by(views: Path, capsys: pytest.CaptureFixture[str]) -> None:
    film = views / "board.avi"
    writer = cv2.VideoWriter(str(film), cv2.VideoWriter.fourcc(*"MJPG"), 5.0, (WIDTH, HEIGHT))
    for image in (each for each in chessboards()[:6] for _ in range(2)):
        writer.write(cv2.cvtColor(image, cv2.COLOR_GRAY2BGR))
    writer.release()
    assert calibrate(film, "--json", "--quiet") == 0
    told = json.loads(capsys.readouterr().out)
    assert told["used"] == [f"{film} at {second:.1f} s" for second in (0.2, 0.6, 1.0, 1.4, 1.8, 2.2)]
    assert told["fx"] == pytest.approx(FX, rel=0.03)


def test_too_few_views_name_the_images_without_a_board(views: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert calibrate(views / "0.png", views / "wall.png", "--quiet") == 1
    error = capsys.readouterr().err
    assert "acromovi camera: 1 different views of the board of 9 x 6 inner corners were found; take at least 6" in error
    assert f"{views / 'wall.png'} does not show the whole board" in error


def test_the_team_file_is_left_alone_if_the_camera_cannot_be_calibrated(views: Path) -> None:
    team = views.parent / "mine.toml"
    assert calibrate(views / "0.png", "--quiet", "--into", team, "doc") == 1
    assert team.read_text(encoding="utf-8") == TEAM


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (["there-is-none.png"], "there is no file there-is-none.png"),
        (["{views}"], "is a folder; give its images"),
        (["{views}/0.png", "--into", "nowhere.toml", "doc"], "there is no team file nowhere.toml"),
        (["{views}/0.png", "--into", "{views}/../mine.toml", "happy"], "no robot 'happy' in this team"),
        (["{views}/0.png", "--into", "{views}/../mine.toml", "doc/left"], "doc/left is not ROBOT or ROBOT/camera"),
        (["{views}/0.png", "--square", "0"], "must be more than 0 m"),
        (["{views}/0.png", "--board", "5x5"], "not the same number"),
        (["{views}/../mine.toml"], "mine.toml: "),
        (["nobody", "--bus", private_bus()], "there is no robot 'nobody'"),
        (["http://127.0.0.1:1/video"], "does not answer"),
    ],
)
def test_mistakes_are_told_in_a_sentence(
    views: Path, words: list[str], why: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert calibrate(*(word.format(views=views) for word in words), "--quiet") == 1
    error = capsys.readouterr().err
    assert error.startswith("acromovi camera: ")
    assert why in error
    assert "Traceback" not in error


def test_a_board_without_its_size_is_wrong_usage(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        calibrate("a.png", "--board", "nine")
    assert ended.value.code == 2
    assert "write for example 9x6" in capsys.readouterr().err

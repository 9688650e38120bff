"""`acromovi world` finds an emulator, and looks at and changes its world."""

import json
import socket
import tempfile
import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

import configs
from acromovi.__main__ import main
from p2os_emu.program import EmulatedRobots, emulator

Asked = Callable[..., tuple[int, str, str]]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """In place of the folder for temporary files, so that the emulators of other tests are not found."""
    return tmp_path_factory.mktemp("world")


@pytest.fixture(scope="module")
def running(folder: Path) -> Iterator[EmulatedRobots]:
    control = folder / "acromovi-team" / "control"
    control.parent.mkdir()
    with emulator("--robot", "p3dx:anna", "--world", "people-lab", "--perfect", "--control", str(control)) as robots:
        yield robots


@pytest.fixture
def asked(
    running: EmulatedRobots, folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Asked:
    monkeypatch.setattr(tempfile, "tempdir", str(folder))

    def ask(*words: str) -> tuple[int, str, str]:
        try:
            code = main(["world", *words])
        except SystemExit as err:
            code = int(str(err.code))
        return code, *capsys.readouterr()

    return ask


def test_the_truth_is_a_table_for_people_and_json_for_programs(asked: Asked) -> None:
    code, printed, _ = asked("truth")
    assert code == 0
    lines = printed.splitlines()
    assert lines[0].split("  ")[0] == "robot"
    assert lines[1].split()[:2] == ["anna", "p3dx"]
    assert [line.split()[0] for line in lines if line.endswith("walks")] == ["Anna", "Bert", "Carl"]
    assert json.loads(asked("truth", "anna", "--json")[1])["robots"].keys() == {"anna"}


def test_a_robot_is_put_somewhere_and_found_there(asked: Asked) -> None:
    assert asked("pose", "anna", "3", "3", "1.5") == (0, "anna is at 3.00, 3.00 m, 1.50 rad\n", "")
    assert asked("pose", "anna")[1] == "anna is at 3.00, 3.00 m, 1.50 rad\n"
    code, _, error = asked("pose", "anna", "3")
    assert (code, error) == (2, "acromovi world: a place is X Y or X Y HEADING\n")


def test_time_is_paused_stepped_and_resumed(asked: Asked) -> None:
    before = json.loads(asked("pause", "--json")[1])
    after = json.loads(asked("step", "120", "--json")[1])
    assert after["time"] - before["time"] == pytest.approx(1.0)
    assert "paused" in asked("truth")[1]
    assert asked("resume")[1].endswith("speed 1\n")
    assert asked("step")[2] == 'acromovi world: the emulator runs by the clock; {"do": "pause"} first\n'
    assert asked("speed", "2")[1] == "speed 2\n"
    assert asked("speed", "1")[0] == 0


def test_faults_are_applied_listed_and_cleared(asked: Asked) -> None:
    assert "line-cut" in asked("fault", "line-cut:robot=anna")[1]
    shown = asked("faults")[1]
    assert "for ever" in shown
    assert "sonar discs hear nothing" in shown
    assert asked("clear")[1] == "cleared: 1\n"
    assert asked("clear")[1] == "cleared: none was applied\n"
    code, _, error = asked("fault", "line-kut")
    assert (code, "line-cut" in error) == (1, True)


def test_robots_come_and_go(asked: Asked) -> None:
    code, printed, _ = asked("add", "p2dx", "--name", "bob")
    assert (code, printed.startswith("added bob, its port is ")) == (0, True)
    assert asked("reset", "bob")[1] == "restarted bob\n"
    assert asked("remove", "bob")[1] == "removed bob\n"
    assert asked("remove", "bob")[2] == "acromovi world: there is no robot 'bob'; choose one of anna\n"
    assert asked("add", "p2dx", "--heading", "1")[2] == "acromovi world: --heading needs --at\n"


def test_a_model_beside_the_command_is_found_by_an_emulator_elsewhere(
    asked: Asked, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    known = configs.find("robots", "p2dx").read_text(encoding="utf-8")
    Path("mine.toml").write_text(known, encoding="utf-8")
    assert asked("add", "mine.toml", "--name", "bob")[1].startswith("added bob, its port is ")
    assert asked("remove", "bob")[0] == 0
    assert asked("add", "mein.toml")[2].startswith("acromovi world: there is no file mein.toml; ")
    assert asked("add", "p2d")[2].startswith("acromovi world: there is no 'p2d' among the robots; did you mean")


def test_a_model_that_no_robot_has_is_refused_and_the_emulator_runs_on(asked: Asked, tmp_path: Path) -> None:
    model = tmp_path / "mine.toml"
    known = configs.find("robots", "p3dx").read_text(encoding="utf-8")
    model.write_text(known.replace('name = "p3dx"', f'name = "{"x" * 20}"'), encoding="utf-8")
    code, _, error = asked("add", str(model), "--name", "bob")
    assert (code, error.count("\n")) == (1, 1)
    assert error.startswith(f"acromovi world: {model}: name must have 1 to 19 characters")
    assert asked("truth", "anna")[0] == 0


def test_doors_people_and_objects_are_listed(asked: Asked) -> None:
    assert asked("doors")[1].splitlines()[1].split() == ["door", "1.20", "1.20"]
    assert asked("door", "door", "shut")[1] == "door shuts\n"
    assert asked("people")[1].count("\n") == 4
    assert asked("objects")[1] == "no objects in this world\n"
    assert asked("joystick", "anna", "0", "1")[2].startswith("acromovi world: anna has no joystick fitted")


def test_the_emulators_that_run_are_listed(asked: Asked, running: EmulatedRobots) -> None:
    (row,) = json.loads(asked("list", "--json")[1])["emulators"]
    assert (row["control"], row["robots"]) == (running.control, ["anna"])
    assert asked("list")[1].startswith(f"{running.control}  anna  ")


def test_of_several_emulators_the_one_with_the_robot_is_meant(asked: Asked, folder: Path) -> None:
    (folder / "p2os-emu-other").mkdir()
    with emulator("--robot", "p2dx:otto", "--control", str(folder / "p2os-emu-other" / "control")) as other:
        assert asked("pose", "anna")[0] == asked("pose", "otto")[0] == 0
        code, _, error = asked("pause")
        assert (code, error.startswith("acromovi world: 2 emulators run here; choose one: --control ")) == (1, True)
        assert asked("truth", "--control", other.control)[0] == 0


def test_a_socket_that_nobody_hears_and_one_of_something_else_are_refused(asked: Asked, folder: Path) -> None:
    assert (
        "absent does not answer as a control socket (No such file"
        in asked("truth", "--control", str(folder / "absent"))[2]
    )
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as server:
        server.bind(str(folder / "strange"))
        server.listen()
        server.settimeout(20.0)

        def answer() -> None:
            connection, _ = server.accept()
            with connection:
                connection.recv(100)
                connection.sendall(b"hello\n")

        thread = threading.Thread(target=answer)
        thread.start()
        assert "strange does not answer as a control socket" in asked("truth", "--control", str(folder / "strange"))[2]
        thread.join()


def test_without_an_emulator_it_says_how_to_start_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    assert main(["world", "truth"]) == 1
    assert "no emulator runs here; start one with p2os-emu or acromovi up" in capsys.readouterr().err
    assert main(["world", "list"]) == 0

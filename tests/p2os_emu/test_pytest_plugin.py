"""The fixtures that come with the distribution, in a pytest of their own as a stranger's project would run it."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from p2os_emu.program import ChildFailed
from p2os_emu.robot_for_tests import RobotForTests, start
from tests.waiting import run, wait_until

LIMIT = 60.0  # s; generous, a pytest of one test takes about one
OWN_FILES = {"PYTHONPATH": str(Path(__file__).parents[2])}


def pytest_in(folder: Path, *arguments: str) -> "subprocess.CompletedProcess[str]":
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-W", "error", *arguments]
    return run(command, LIMIT, cwd=folder, env={**os.environ, **OWN_FILES})


def test_robot_is_on_a_port_of_its_own_and_can_be_placed(emulated_robot: RobotForTests) -> None:
    assert Path(emulated_robot.port).exists()
    assert (emulated_robot.laser_port, emulated_robot.camera_url) == (None, None)
    emulated_robot.place(1.0, -2.0, 0.5)
    truth = emulated_robot.wait_until_it_stands()
    assert (truth.x, truth.y, truth.heading) == pytest.approx((1.0, -2.0, 0.5), abs=1e-3)
    assert not truth.connected


@pytest.mark.emulated_robot("powerbot:happy", world="office", seed=3, flash={"watchdog": 1.0}, faults=["line-cut@0+9"])
def test_marker_chooses_model_world_and_faults(emulated_robot: RobotForTests) -> None:
    assert (emulated_robot.name, emulated_robot.model) == ("happy", "powerbot")
    assert [row["fault"] for row in emulated_robot.emulator.ask("faults")["faults"]] == ["line-cut@0.0+9.0"]
    emulated_robot.clear()
    assert emulated_robot.emulator.ask("faults")["faults"] == []


@pytest.mark.emulated_robot("p3dx:happy", options=["--robot", "amigo:grumpy"])
@pytest.mark.parametrize("spec", ["stop-pressed", "low-battery:volts=11", "line-cut@0.01", "line-noisy:rate=0.1@0+60"])
def test_fault_befalls_this_robot_and_can_be_cleared_twice(emulated_robot: RobotForTests, spec: str) -> None:
    fault = emulated_robot.fault(spec)
    assert "robot=happy" in fault.spec
    emulated_robot.wait_until(lambda truth: truth.time > 0.1)
    fault.clear()
    assert fault.is_over
    fault.clear()
    assert emulated_robot.emulator.ask("faults")["faults"] == []


def test_fault_that_the_robot_cannot_suffer_is_refused_with_those_it_can(emulated_robot: RobotForTests) -> None:
    with pytest.raises(ChildFailed, match=r"p3dx has no bumpers to suffer bumper-stuck; p3dx can suffer sonar-dead, "):
        emulated_robot.fault("bumper-stuck")


def test_vain_wait_says_what_it_waited_for_and_how_the_robot_is(emulated_robot: RobotForTests) -> None:
    with pytest.raises(AssertionError, match=r"in vain until a client connected; the robot is as follows: .*x=0\.0"):
        emulated_robot.wait_until_connected(seconds=0.0)


STRANGER = """
import pytest

@pytest.mark.emulated_robot({marker})
def test_robot(emulated_robot):
    with open("port", "a") as file:
        print(emulated_robot.emulator.process.pid, file=file)
    {rest}
"""


REFUSED = {
    "'p3dxx'": "there is no 'p3dxx' among the robots; did you mean",
    "fit='lasers'": "there is no part 'lasers'; did you mean laser or camera?",
    "faults=['line-cutt']": "there is no fault 'line-cutt'; did you mean line-cut",
    "options=['--speed', '-1']": "argument --speed: '-1' will not do; give a number above zero",
    "'p3dx', 'amigo'": "emulated_robot is one robot, not 2; emulate_robots gives several",
}


def test_robot_that_cannot_be_had_fails_the_test_with_the_emulators_sentence(tmp_path: Path) -> None:
    for number, marker in enumerate(REFUSED):
        (tmp_path / f"test_stranger_{number}.py").write_text(STRANGER.format(marker=marker, rest="pass"))
    result = pytest_in(tmp_path)
    assert result.returncode == pytest.ExitCode.TESTS_FAILED
    assert f"{len(REFUSED)} errors" in result.stdout
    for sentence in REFUSED.values():
        assert sentence in result.stdout
    assert "Traceback" not in result.stdout
    assert "program.py" not in result.stdout


def test_strangers_tests_run_in_parallel_with_strict_markers(tmp_path: Path) -> None:
    test = STRANGER.format(marker="", rest="assert emulated_robot.truth().time >= 0")
    for number in range(2):
        (tmp_path / f"test_stranger_{number}.py").write_text(test)
    result = pytest_in(tmp_path, "-n", "2", "--strict-markers")
    assert result.returncode == 0, result.stdout
    assert all(is_gone(int(pid)) for pid in (tmp_path / "port").read_text().split())


def test_emulator_ends_with_a_test_that_was_killed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folders = tmp_path / "folders"
    folders.mkdir()
    monkeypatch.setenv("TMPDIR", str(folders))
    rest = "import os, signal; os.kill(os.getpid(), signal.SIGKILL)"
    (tmp_path / "test_stranger.py").write_text(STRANGER.format(marker="", rest=rest))
    assert pytest_in(tmp_path).returncode < 0
    pid = int((tmp_path / "port").read_text())
    wait_until(lambda: is_gone(pid), "the emulator ends with its test")
    assert not list(folders.glob("p2os-emu-*"))


def test_emulator_that_a_test_kills_leaves_no_folder() -> None:
    with start("p3dx") as (other,):
        folder = Path(other.emulator.control).parent
        other.emulator.process.kill()
    assert not folder.exists()


def is_gone(pid: int) -> bool:
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except (FileNotFoundError, ProcessLookupError):  # it has ended
        return True
    return state == "Z"  # dead, and its adoptive parent has not looked yet


def test_plugin_loads_neither_physics_nor_numbers() -> None:
    code = "import sys, p2os_emu.pytest_plugin; print({'numpy', 'pybullet', 'zenoh', 'p2os'} & set(sys.modules))"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert result.stdout == "set()\n"


def test_fixtures_explain_themselves(tmp_path: Path) -> None:
    said = pytest_in(tmp_path, "--fixtures").stdout
    assert "An emulated robot of this test's own" in said
    assert "Factory of emulated robots" in said

"""Files of faults."""

from pathlib import Path

import pytest

import configs
from p2os import RobotModel
from p2os_emu.emulator import Emulator
from p2os_emu.fault_spec import FaultError
from p2os_emu.faults.board import FaultBoard
from p2os_emu.links.line import LinkProfile
from p2os_emu.links.memory import MemoryLink
from p2os_emu.program import ChildFailed
from p2os_emu.robot_for_tests import start
from tests.p2os_emu.flat_world import FlatWorld


@pytest.fixture
def board() -> FaultBoard:
    emulator = Emulator(FlatWorld(), LinkProfile("ideal"))
    emulator.add("happy", configs.load(RobotModel, "robots", "p3dx"), MemoryLink())
    return FaultBoard(emulator.robots)


def test_each_line_is_a_fault_and_comments_are_none(board: FaultBoard, tmp_path: Path) -> None:
    file = tmp_path / "storm.faults"
    file.write_text(
        "# a bad day\n\nline-cut@10+5   # the cable\n  sonar-dead:robot=happy,disc=3@5+10\nstop-pressed@30\n"
    )
    board.schedule_file(file, 2.0)
    assert [(fault.kind.name, fault.start, fault.end) for fault in board.faults] == [
        ("line-cut", 12.0, 17.0),
        ("sonar-dead", 7.0, 17.0),
        ("stop-pressed", 32.0, float("inf")),
    ]


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("stop-pressed\nline-cutt@5", r"storm.faults, line 2: there is no fault 'line-cutt'; did you mean line-cut"),
        ("# nothing\n\nline-cut@soon", r"storm.faults, line 3: .*'soon' is not START"),
        ("bumper-stuck", r"storm.faults, line 1: happy has no bumpers to suffer bumper-stuck; happy can suffer"),
    ],
)
def test_wrong_line_is_named_with_its_file(board: FaultBoard, tmp_path: Path, text: str, complaint: str) -> None:
    file = tmp_path / "storm.faults"
    file.write_text(text)
    with pytest.raises(FaultError, match=complaint):
        board.schedule_file(file, 0.0)


def test_file_that_cannot_be_read_is_named(board: FaultBoard, tmp_path: Path) -> None:
    with pytest.raises(FaultError, match=r"storm.faults: the file of faults cannot be read: "):
        board.schedule_file(tmp_path / "storm.faults", 0.0)
    (tmp_path / "storm.faults").write_bytes(b"\xff\xfe")
    with pytest.raises(FaultError, match="cannot be read"):
        board.schedule_file(tmp_path / "storm.faults", 0.0)


def test_emulator_takes_the_faults_of_files_and_refuses_wrong_ones_with_their_line(tmp_path: Path) -> None:
    first, second, wrong = (tmp_path / name for name in ("first", "second", "wrong"))
    first.write_text("line-cut@10+5\n")
    second.write_text("stop-pressed@30\n")
    wrong.write_text("stop-pressed@30\nstop-presed@40\n")
    with start("p3dx", options=["--fault-file", str(first), "--fault-file", str(second)]) as (robot,):
        assert [row["start"] for row in robot.emulator.ask("faults")["faults"]] == [10.0, 30.0]
    with (
        pytest.raises(ChildFailed, match="wrong, line 2: there is no fault 'stop-presed'"),
        start("p3dx", options=["--fault-file", str(wrong)]),
    ):
        pass

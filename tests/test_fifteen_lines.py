"""The two programs that a student can write: short enough, and right on a team of two."""

import ast
import re
from pathlib import Path

import pytest

from tests.live_team import ROOT, live_team

EXAMPLES = ROOT / "examples"
PROGRAMS = ("square.py", "nearest.py")
MOST_LINES = 15
TEAM = """
world = "office"

[[robots]]
name = "happy"
model = "p3dx-sh"
fit = ["laser"]
at_m = [14.0, 6.1]

[[robots]]
name = "grumpy"
model = "p2dx"
at_m = [9.0, 6.1]
"""


@pytest.mark.parametrize("program", PROGRAMS)
def test_a_program_for_students_has_at_most_fifteen_lines(program: str) -> None:
    tree = ast.parse((EXAMPLES / program).read_text())
    docstring = tree.body[0]
    assert ast.get_docstring(tree)
    written = (EXAMPLES / program).read_text().splitlines()[docstring.end_lineno :]
    assert len([line for line in written if line.strip()]) <= MOST_LINES


def test_programs_for_students_run_on_a_team_of_two(tmp_path: Path) -> None:
    with live_team(tmp_path, TEAM) as team:
        looked = team.run("python", str(EXAMPLES / "nearest.py"))
        assert re.fullmatch(r"happy: \d\.\d\d m\n", looked.stdout), looked.stderr
        driven = team.run("python", str(EXAMPLES / "square.py"), "grumpy")
        pose = re.fullmatch(r"back at Pose2D\(x=(.*), y=(.*), heading=(.*)\)\n", driven.stdout)
        assert pose is not None, driven.stderr
        assert all(abs(float(value)) < 0.2 for value in pose.groups())
        lost = team.run("python", str(EXAMPLES / "square.py"), "hapy")
        assert lost.returncode == 1
        assert lost.stderr == "no square: there is no robot 'hapy'; did you mean 'happy'? There are grumpy and happy\n"

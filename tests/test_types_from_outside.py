"""Type checkers find the types of each package from another project, in the editable installation of `make` too."""

import os
import re
import subprocess
import sys
from pathlib import Path

PROGRAM = '''\
"""Each line after the imports passes an argument of a wrong type."""

import agents
import agents.platform
import bus
import cameras
import configs
import gateway
import geometry
import p2os
import p2os_emu

agents.Team(3)
agents.platform.Outcome("done")
bus.ZenohBus.open(3)
cameras.open_source(3)
configs.load(geometry.Pose2D, "robots", 3)
gateway.start(3)
geometry.Pose2D("east")
p2os.encode_command("VEL")
p2os_emu.start(3)
'''


MISTAKES = [number for number, line in enumerate(PROGRAM.splitlines(), 1) if line.endswith(")")]


def test_mypy_finds_the_types_of_every_package(tmp_path: Path) -> None:
    (tmp_path / "program.py").write_text(PROGRAM)
    search_paths = {"PYTHONPATH", "MYPYPATH"}
    environment = {name: value for name, value in os.environ.items() if name not in search_paths}
    command = [sys.executable, "-m", "mypy", "--strict", "program.py"]
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    found = re.findall(r"^program\.py:(\d+): error: .*\[([\w-]+)\]$", done.stdout, re.MULTILINE)
    assert found == [(str(line), "arg-type") for line in MISTAKES], done.stdout + done.stderr

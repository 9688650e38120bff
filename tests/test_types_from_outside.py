"""Type checkers find the types of each package from another project, in the editable installation of `make` too."""

import os
import subprocess
import sys
from pathlib import Path

PROGRAM = '''\
"""Each line holds a mistake; mypy reports an ignored error that it does not find."""

import agents
import agents.platform
import bus
import cameras
import configs
import gateway
import geometry
import p2os
import p2os_emu

agents.Team(3)  # type: ignore[arg-type]
agents.platform.Outcome("done")  # type: ignore[arg-type]
bus.ZenohBus.open(3)  # type: ignore[arg-type]
cameras.open_source(3)  # type: ignore[arg-type]
configs.load(geometry.Pose2D, "robots", 3)  # type: ignore[arg-type]
gateway.start(3)  # type: ignore[arg-type]
geometry.Pose2D("east")  # type: ignore[arg-type]
p2os.encode_command("VEL")  # type: ignore[arg-type]
p2os_emu.start(3)  # type: ignore[arg-type]
'''


def test_mypy_finds_the_types_of_every_package(tmp_path: Path) -> None:
    (tmp_path / "program.py").write_text(PROGRAM)
    search_paths = {"PYTHONPATH", "MYPYPATH"}
    environment = {name: value for name, value in os.environ.items() if name not in search_paths}
    command = [sys.executable, "-m", "mypy", "--strict", "program.py"]
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert done.stdout == "Success: no issues found in 1 source file\n", done.stdout + done.stderr

"""The camera of an emulated robot is calibrated as the page of the vision agents shows: before the board of a world."""

import json
import math
import os
import signal
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from tests.acromovi.team.running import ROOT, RunningTeam, running
from tests.apps.on_a_team import LITTLE, stands, step
from tests.shown import files
from tests.waiting import end_of, wait_until

WIDTH, FIELD_OF_VIEW = 320, math.radians(47.5)  # of the VC-C4 at its widest zoom

LONG = "3000"  # s; how long the test waits is decided below


def drives(team: RunningTeam) -> bool:
    return step(team, "bart") > 5 * LITTLE


def test_the_program_of_the_page_moves_the_robot_until_its_camera_is_calibrated_also_after_a_freeze(
    tmp_path: Path,
) -> None:
    file, program = tmp_path / "board.toml", tmp_path / "look.py"
    file.write_text(next(text for text in files("vision", "toml") if "chessboard-lab" in text))
    program.write_text(next(text for text in files("vision", "python") if "look_about" in text))
    with running(str(file)) as team:
        calibrate = ("-m", "acromovi", "camera", "calibrate", "bart", "--square", "0.05", "--json", "--timeout", LONG)
        into = ("--into", str(file), "bart", "--bus", team.profile)
        environment = {**os.environ, "PYTHONPATH": str(ROOT), "ACROMOVI_BUS": team.profile}
        with (
            subprocess.Popen([sys.executable, *calibrate, *into], stdout=subprocess.PIPE, text=True) as calibration,
            subprocess.Popen(
                [sys.executable, str(program)], env=environment, stderr=subprocess.PIPE, text=True
            ) as drive,
        ):
            try:
                wait_until(lambda: drive.poll() is not None or drives(team), "it drives")
                drive.send_signal(signal.SIGSTOP)
                wait_until(lambda: stands(team, "bart"), "it stands")
                drive.send_signal(signal.SIGCONT)
                wait_until(lambda: drive.poll() is not None or drives(team), "it drives again")
                wait_until(
                    lambda: (calibration.poll(), drive.poll()) != (None, None), "the camera is calibrated", 150.0
                )
                assert drive.poll() is None, end_of(drive)  # it goes on without end
                assert calibration.returncode == 0, end_of(calibration)
                assert calibration.stdout is not None
                told = json.loads(calibration.stdout.read())
            finally:
                calibration.kill()
                drive.kill()
    # The emulator draws without smoothing, so corners are found to a third of a pixel only.
    assert told["fx"] == pytest.approx(WIDTH / 2.0 / math.tan(FIELD_OF_VIEW / 2.0), rel=0.02)
    assert told["error_px"] < 0.5
    (robot,) = tomllib.loads(file.read_text())["robots"]
    assert robot["camera_calibration"]["width"] == WIDTH

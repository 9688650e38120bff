"""The conformance suite asks every emulated model, in virtual time.

What is the same for all firmware is asked in real time of a few models, by the suite's own run, and left out here.
"""

import os
import re
import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest

import configs
from p2os import RobotModel
from p2os.firmware import FIRMWARES, Family
from tests.waiting import run

ROOT = Path(__file__).parents[2]
LEFT_OUT = (
    "pty_tests/test_firmware.py",  # asks no robot
    # Asks for each command alone; the test after it sends all of them to each model.
    "pty_tests/test_rows.py::test_a_command_that_concerns_something_else_does_not_disturb",
    "pty_tests/test_questions.py",  # any answer is right, and goes to a report
    "pty_tests/test_client.py",  # asks no robot
    "pty_tests/test_captures.py",  # measures streams by the real clock
    "pty_tests/test_foreign_driver.py",  # a driver that opens devices only
)
UNUSED = ("cacheprovider", "hypothesispytest", "xdist")
"""Plugins that the suite does not need, and that take longer to load than a model is asked."""
TOGETHER = 10
"""Models that one process asks."""
LIMIT = 110.0  # s for all of them
REASONS = (
    r"\w+( for one array)? came with .*",
    r"this firmware's CONFIGpac has no \w+",
    r"the robot does not answer: it has no such accessory",
    r"no Canon camera answers on AUX1",
    r"resets the controller: only of an emulated robot",
)
"""Why a test may be skipped here."""
ASKED_AT_LEAST = 80
"""Tests of any model; there are about 120, and the oldest firmware is asked the fewest."""


def judge(models: Sequence[str], *arguments: str) -> "subprocess.CompletedProcess[str]":
    """Run the suite on some models in virtual time."""
    command = [sys.executable, "-m", "pytest", "pty_tests", "-p", "tests.conformance.plugin"]
    command += [text for plugin in UNUSED for text in ("-p", f"no:{plugin}")]
    command += ["--may-move", "-q", *arguments, *(f"--port=virtual://{model}" for model in models)]
    command += [f"--deselect={each}" for each in LEFT_OUT if "::" in each]
    command += [f"--ignore={each}" for each in LEFT_OUT if "::" not in each]
    # A worker of this run must not pass for one of that run.
    environment = {key: value for key, value in os.environ.items() if not key.startswith("PYTEST_")}
    return run(command, LIMIT, cwd=ROOT, env=environment)


def groups() -> Iterator[tuple[Family, list[str]]]:
    """Every model, a few of one firmware at a time."""
    for family in Family:
        models = [name for name in configs.names("robots") if firmware_of(name) is family]
        yield from ((family, models[at : at + TOGETHER]) for at in range(0, len(models), TOGETHER))


def firmware_of(name: str) -> Family:
    return configs.load(RobotModel, "robots", name).firmware


@pytest.mark.parametrize(("family", "models"), list(groups()))
def test_the_suite_passes_on_every_emulated_model(family: Family, models: list[str]) -> None:
    # CONFIGpacs of this family have no version.
    told = [f"--firmware=P2OS {FIRMWARES[family].version}"] if family is Family.P2OS else []
    done = judge(models, *told)
    assert done.returncode == 0, done.stdout + done.stderr
    robots = re.findall(r"^robot: ([^,]+), ", done.stdout, re.MULTILINE)
    assert sorted(robots) == sorted(models)
    passed = re.search(r"(\d+) passed", done.stdout)
    assert passed is not None
    assert int(passed[1]) >= ASKED_AT_LEAST * len(models), done.stdout
    for reason in re.findall(r"^not asked, since (.*):$", done.stdout, re.MULTILINE):
        assert any(re.fullmatch(each, reason) for each in REASONS), reason


def test_a_p2os_robot_that_reports_no_version_is_asked_only_what_the_oldest_with_a_configpac_knows() -> None:
    done = judge(["p2dx"])
    assert done.returncode == 0, done.stdout + done.stderr
    assert re.search(r"^robot: p2dx, P2OS 1\.4 \(or later: ", done.stdout, re.MULTILINE)
    assert re.search(r"^not asked, since IOREQUEST came with P2OS 1\.E:$", done.stdout, re.MULTILINE)

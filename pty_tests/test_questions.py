"""The matters that no public source settles: asked of the robot, taken down, and written to the report.

A robot must survive every question; what it answers is its own affair.
"""

import json
import time
from collections.abc import Iterator, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest
import serial

from pty_tests.client import CLOSE, Client, frame
from pty_tests.conftest import Site
from pty_tests.questions import LASER_QUESTIONS, QUESTIONS, Question

ONE_MODEL = pytest.mark.emulate("powerbot-sh:gripper,gyro,compass,joystick")

Taken = list[dict[str, Any]]


class Report:
    """The answers of one robot, kept until the session ends."""

    def __init__(self, path: Path | None) -> None:
        self.patience = 1.0 if path else 0.3  # without a report it is enough that the robot survives
        self._path = path
        self._robots: dict[str, dict[str, Any]] = {}

    def add(self, site: Site, identity: Sequence[str], question: Question, taken: Taken) -> None:
        """Keep what came after a question; writes the file anew, so that nothing is lost if the session ends badly."""
        robot = self._robots.setdefault(
            site.port, {"identity": list(identity), "emulated": site.emulated, "answers": []}
        )
        robot["answers"].append(
            {"question": question.name, "asks": question.asks, "reading": question.reading, "bytes": taken}
        )
        if self._path is not None:
            report = {"report": "P2OS conformance", "written": datetime.now(UTC).isoformat(timespec="seconds")}
            self._path.write_text(json.dumps(report | {"robots": list(self._robots.values())}, indent=1) + "\n")


@pytest.fixture(scope="session")
def report(request: pytest.FixtureRequest) -> Report:
    path = request.config.getoption("--report")
    return Report(Path(path) if path else None)


@pytest.fixture
def asked(site: Site) -> Iterator[tuple[Client, tuple[str, ...]]]:
    """A cable to a robot that waits, and the robot's identity."""
    with Client(site.port, site.baud) as client:
        identity = tuple(client.sync())
        client.hang_up()
        yield client, identity
        client.send(CLOSE, 1)


def take_down(client: Client, question: Question, patience: float) -> Taken:
    """Every frame sent and heard, with its time, s since the question began."""
    began = time.monotonic()
    taken: Taken = []
    pauses = [question.pause] * (len(question.send) - 1)
    for raw, seconds in zip(question.send, (*pauses, question.listen), strict=True):
        taken.append({"t": round(time.monotonic() - began, 3), "from": "host", "hex": raw.hex(" ")})
        client.write(raw)
        for heard in client.hear(seconds * patience, pulse=question.connected):
            taken.append({"t": round(heard.at - began, 3), "from": "robot", "hex": frame(heard.payload).hex(" ")})
    return taken


@ONE_MODEL
@pytest.mark.parametrize("question", [question for question in QUESTIONS if not question.moves], ids=lambda q: q.name)
def test_a_question_is_survived_and_its_answer_taken_down(
    site: Site, asked: tuple[Client, tuple[str, ...]], report: Report, question: Question
) -> None:
    client, identity = asked
    if question.connected:
        client.connect()
    report.add(site, identity, question, take_down(client, question, report.patience))
    client.hang_up()  # which proves that the robot still listens


@ONE_MODEL
@pytest.mark.moves
@pytest.mark.parametrize("question", [question for question in QUESTIONS if question.moves], ids=lambda q: q.name)
def test_a_question_about_driving_is_survived_and_its_answer_taken_down(
    site: Site, asked: tuple[Client, tuple[str, ...]], report: Report, question: Question
) -> None:
    test_a_question_is_survived_and_its_answer_taken_down(site, asked, report, question)


@pytest.mark.parametrize("question", LASER_QUESTIONS, ids=lambda q: q.name)
@pytest.mark.emulate("p3dx-sh:laser")
def test_a_question_to_the_laser_is_taken_down(site: Site, report: Report, question: Question) -> None:
    if site.laser is None:
        pytest.skip("no laser: give its port with --laser PORT")
    began = time.monotonic()
    taken: Taken = []
    with serial.serial_for_url(site.laser, baudrate=9600, timeout=0.05) as line:
        for raw in question.send:
            line.write(raw)
            taken.append({"t": 0.0, "from": "host", "hex": raw.hex(" ")})
        while time.monotonic() - began < question.listen:
            if data := line.read(256):
                taken.append({"t": round(time.monotonic() - began, 3), "from": "laser", "hex": data.hex(" ")})
    report.add(site, ("laser",), question, taken)
    if "damaged" not in question.name:
        assert len(taken) > len(question.send), "the laser does not answer at 9600 bit/s"

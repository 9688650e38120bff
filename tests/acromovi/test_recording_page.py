"""The commands and the program of the page on recordings, on a bus of their own."""

import shlex
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from acromovi.__main__ import main
from bus import ZenohBus
from tests.acromovi.team.private_bus import private_bus
from tests.recorder.recordings import odometry
from tests.shown import command_lines, files

SHORT = {"--seconds 10": "--seconds 1"}


@contextmanager
def publishing(profile: str) -> Iterator[None]:
    """A robot that publishes odometry, while the block runs."""
    done = threading.Event()
    with ZenohBus.open(profile) as bus:

        def publish() -> None:
            count = 0
            while not done.wait(0.05):
                bus.put("happy/odom", odometry("happy", 0.01 * count, 1_700_000_000_000_000_000 + count))
                count += 1

        thread = threading.Thread(target=publish)
        thread.start()
        try:
            yield
        finally:
            done.set()
            thread.join()


def test_the_page_can_be_followed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    profile = private_bus()
    monkeypatch.setenv("ACROMOVI_BUS", profile)
    monkeypatch.chdir(tmp_path)
    record, replay, plot = command_lines("recording", "acromovi")
    for long, short in SHORT.items():
        record = record.replace(long, short)
    with publishing(profile):
        assert main(shlex.split(record)[1:]) == 0
        assert main(shlex.split(replay)[1:]) == 0
    assert "published" in capsys.readouterr().out
    assert main(shlex.split(plot)[1:]) == 0
    assert Path("drive.png").stat().st_size > 1000
    (program,) = files("recording", "python")
    names: dict[str, Any] = {}
    exec(program, names)
    published = names["publisher"].published
    assert published > 5

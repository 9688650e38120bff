"""The keys of a replay in a terminal."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest

from acromovi.replay import PlaybackKeys
from recorder.playback import Playback
from recorder.recording import McapRecording
from tests.recorder.recordings import drive


class TypedTerminal:
    """Gives what is typed, and keeps what is shown."""

    def __init__(self) -> None:
        self.typed: bytes | None = b""
        self.shown: Sequence[str] = ()

    def read(self, timeout: float) -> bytes | None:
        """What was typed."""
        typed, self.typed = self.typed, b""
        return typed

    def show(self, lines: Sequence[str]) -> None:
        """Keep the screen."""
        self.shown = lines


@pytest.fixture
def recording(tmp_path: Path) -> Iterator[McapRecording]:
    with McapRecording.open(drive(tmp_path / "drive.mcap", seconds=30.0)) as opened:
        yield opened


def test_keys_pause_jump_and_change_the_speed(recording: McapRecording) -> None:
    terminal: Any = TypedTerminal()
    playback, keys = Playback(recording), PlaybackKeys(terminal, recording)
    playback.resume(0.0)

    def press(data: bytes) -> bool:
        terminal.typed = data
        return keys.look(playback, 0.0)

    assert press(b" ")
    assert playback.next_at() is None
    assert "paused" in terminal.shown[0]
    assert press(b"\x1b[C\x1b[C")
    assert playback.elapsed == pytest.approx(20.0, abs=0.1)
    assert press(b"\x1b[D")
    assert playback.elapsed == pytest.approx(10.0, abs=0.1)
    assert press(b"0")
    assert playback.elapsed == 0.0
    assert press(b"++-")
    assert playback.speed == 2.0
    assert press(b"+" * 20)
    assert playback.speed == 100.0
    assert press(b" ")
    assert playback.next_at() is not None
    assert "of 30 s, speed 100" in terminal.shown[0]
    assert not press(b"q")


def test_a_terminal_that_is_gone_ends_it(recording: McapRecording) -> None:
    terminal: Any = TypedTerminal()
    terminal.typed = None
    assert not PlaybackKeys(terminal, recording).look(Playback(recording), 0.0)

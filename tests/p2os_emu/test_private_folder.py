"""Folders of control sockets: nothing stays behind, whatever was killed."""

import os
import socket
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from p2os_emu.private_folder import CONTROL, PREFIX, SETTLED, private_folder


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """The system's folder for what lasts a run; sockets need a short path."""
    with tempfile.TemporaryDirectory() as folder:
        monkeypatch.setattr(tempfile, "tempdir", folder)
        yield Path(folder)


def folder_with_socket(place: Path, name: str, age: float) -> tuple[Path, socket.socket]:
    folder = place / f"{PREFIX}{name}"
    folder.mkdir()
    listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    listener.bind(str(folder / CONTROL))
    listener.listen()
    before = time.time() - age
    os.utime(folder, (before, before))
    return folder, listener


def test_folder_goes_with_the_block(place: Path) -> None:
    with private_folder() as folder:
        assert folder.parent == place
        assert folder.stat().st_mode & 0o777 == 0o700
    assert not list(place.iterdir())


def test_folder_of_a_killed_emulator_is_swept_and_no_other(place: Path) -> None:
    left_over, killed = folder_with_socket(place, "killed", SETTLED + 1)
    just_made, starting = folder_with_socket(place, "starting", 0.0)
    in_use, running = folder_with_socket(place, "running", SETTLED + 1)
    killed.close()
    starting.close()
    (place / f"{PREFIX}flash").mkdir()
    with private_folder():
        pass
    assert not left_over.exists()
    assert just_made.exists()
    assert in_use.exists()
    assert (place / f"{PREFIX}flash").exists()
    running.close()

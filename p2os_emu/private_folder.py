"""The folder of a control socket for which nobody has named a place: made for one run, gone after it.

A run that was killed cannot remove its own; the next one does.
"""

import os
import shutil
import socket
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

PREFIX = "p2os-emu-"
CONTROL = "control"
SETTLED = 60.0
"""Seconds after which a folder whose socket nobody hears is left over, and not about to be used."""


@contextmanager
def private_folder() -> Iterator[Path]:
    """A folder that only this user can enter, until the block ends."""
    _sweep_left_over()
    with tempfile.TemporaryDirectory(prefix=PREFIX) as folder:
        yield Path(folder)


def _sweep_left_over() -> None:
    """Remove this user's folders in which nobody listens any more."""
    for folder in Path(tempfile.gettempdir()).glob(f"{PREFIX}*"):
        with suppress(OSError):  # another emulator was quicker
            status = folder.stat()
            if status.st_uid == os.getuid() and time.time() - status.st_mtime > SETTLED and _is_deserted(folder):
                shutil.rmtree(folder)


def sweep(folder: Path) -> None:
    """Remove the folder of an emulator that has ended, if it was a private one and is there still."""
    if folder.name.startswith(PREFIX):
        shutil.rmtree(folder, ignore_errors=True)  # it may be gone already


def _is_deserted(folder: Path) -> bool:
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as visitor:
        visitor.setblocking(False)  # an emulator that is frozen lets nobody in
        try:
            visitor.connect(str(folder / CONTROL))
        except ConnectionRefusedError:  # nobody listens: its emulator has ended
            return True
    return False

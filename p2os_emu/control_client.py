"""The client's side of the control socket: a request and its reply, and the sockets of the emulators that run here."""

import json
import os
import socket
import tempfile
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from p2os_emu.private_folder import CONTROL, PREFIX

ANSWER_TIME = 5.0  # s for a reply; an emulator that steps ten minutes of paused time takes longer


class ControlRefused(RuntimeError):
    """The emulator refused a request; the message is its own sentence."""


def ask_emulator(path: str | Path, request: dict[str, Any], timeout: float = ANSWER_TIME) -> dict[str, Any]:
    """Send one request to a control socket and return the reply.

    Raises:
        ControlRefused: The emulator refused it.
        OSError: Nobody listens there, or nobody answers in time.
        ValueError: The reply is not JSON: something else listens there.
    """
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as control, control.makefile("rw") as stream:
        control.settimeout(timeout)
        control.connect(str(path))
        stream.write(json.dumps(request) + "\n")
        stream.flush()
        answer = json.loads(stream.readline())
    if not isinstance(answer, dict):
        raise ValueError(f"an emulator answers with a JSON object, not with {answer!r:.80}")
    if not answer.get("ok"):
        raise ControlRefused(str(answer.get("error")))
    return answer


def control_sockets(prefixes: Sequence[str] = (PREFIX,)) -> list[Path]:
    """Return the control sockets of this user's emulators, except for those whose path a person has set.

    Args:
        prefixes: Beginnings of the names of the temporary folders in which they are.
    """
    found = []
    for prefix in prefixes:
        for path in Path(tempfile.gettempdir()).glob(f"{prefix}*/{CONTROL}"):
            with suppress(OSError):  # it ends just now
                if path.is_socket() and path.stat().st_uid == os.getuid():
                    found.append(path)
    return sorted(found)

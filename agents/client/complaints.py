"""Error messages for scripts: one sentence, and the line of the script."""

import sys
import threading
import traceback
from pathlib import Path
from types import TracebackType

from agents.client.errors import RobotError, Stopped
from agents.platform.errors import in_words


def complaint(error: BaseException, file: Path) -> str:
    """Return an exception of a program as one sentence: file, line, and error."""
    if isinstance(error, SyntaxError) and error.filename == str(file):
        return f"{file.name}, line {error.lineno}: {error.msg}"
    frames = traceback.extract_tb(error.__traceback__)
    line = next((frame.lineno for frame in reversed(frames) if frame.filename == str(file)), None)
    where = file.name if line is None else f"{file.name}, line {line}"
    return f"{where}: {in_words(error)}"


def complain_in_a_sentence() -> None:
    """What no script has caught of what went wrong with a robot, and Ctrl-C, is told in a sentence from now on.

    All other errors are told as Python does, and who has arranged for that himself is left alone.
    """
    if sys.excepthook is sys.__excepthook__:
        sys.excepthook = _complain
    if threading.excepthook is threading.__excepthook__:
        threading.excepthook = _complain_of_thread


def _complain(kind: type[BaseException], error: BaseException, trace: TracebackType | None) -> None:
    if isinstance(error, RobotError | Stopped | KeyboardInterrupt):
        what = "stopped by Ctrl-C" if isinstance(error, KeyboardInterrupt) else str(error)
        print(f"{_line_of_script(trace)}{what}", file=sys.stderr)
    else:
        sys.__excepthook__(kind, error, trace)


def _complain_of_thread(failed: threading.ExceptHookArgs) -> None:
    if isinstance(failed.exc_value, RobotError | Stopped):
        _complain(failed.exc_type, failed.exc_value, failed.exc_traceback)
    else:
        threading.__excepthook__(failed)


def _line_of_script(trace: TracebackType | None) -> str:
    """Return the last line of the script in the traceback, as `drive.py, line 5: `."""
    where = ""
    for frame, line in traceback.walk_tb(trace):
        if frame.f_globals.get("__name__") == "__main__":
            where = f"{Path(frame.f_code.co_filename).name}, line {line}: "
    return where

"""Files of faults with their times: one fault a line, as on the command line; `#` begins a comment.

# In the tenth second the cable fails for five seconds, and at last somebody presses stop.
line-cut:robot=happy@10+5
stop-pressed@30
"""

from pathlib import Path

from p2os_emu.fault_spec import FaultError, parse_fault
from p2os_emu.faults.board import FaultBoard


def schedule_file(board: FaultBoard, path: Path, now: float) -> None:
    """Let the faults of a file happen; their starts count from `now`, s of emulated time.

    Raises:
        FaultError: The file cannot be read, or a line is wrong; the message names file and line.
    """
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except OSError as error:
        raise FaultError(f"{path}: the file of faults cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise FaultError(f"{path}: the file of faults cannot be read: it is no text") from error
    for number, line in enumerate(lines, 1):
        text = line.partition("#")[0].strip()
        if not text:
            continue
        try:
            board.schedule(parse_fault(text), now)
        except FaultError as error:
            raise FaultError(f"{path}, line {number}: {error}") from error

"""The terminal of a live program: keys as they come, one line that is written again and again, everything put back."""

import os
import select
import sys
import termios
import tty
from types import TracebackType
from typing import Self

CLEAR_LINE = "\r\x1b[K"
HIDE_CURSOR, SHOW_CURSOR = "\x1b[?25l", "\x1b[?25h"


class Terminal:
    """Standard input without line editing and echo, standard output with one live line; Ctrl-C still interrupts."""

    def __init__(self) -> None:
        self._input = sys.stdin.fileno()
        self._before = termios.tcgetattr(self._input)

    def __enter__(self) -> Self:
        tty.setcbreak(self._input)
        sys.stdout.write(HIDE_CURSOR)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        termios.tcsetattr(self._input, termios.TCSADRAIN, self._before)
        sys.stdout.write(SHOW_CURSOR + "\n")
        sys.stdout.flush()

    def read(self, timeout: float) -> bytes | None:
        """What was typed within `timeout` s; None when the terminal is gone."""
        ready, _, _ = select.select([self._input], [], [], timeout)
        if not ready:
            return b""
        return os.read(self._input, 1024) or None

    def show(self, line: str) -> None:
        """Write the live line again, cut to the width of the terminal."""
        width = os.get_terminal_size(sys.stdout.fileno()).columns
        sys.stdout.write(CLEAR_LINE + line[: max(width - 1, 0)])
        sys.stdout.flush()

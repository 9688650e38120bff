"""Terminal of an interactive program: reads keys, redraws a screen, restores the terminal at the end."""

import os
import select
import sys
import termios
import tty
from collections.abc import Sequence
from typing import Self

HOME, CLEAR_LINE, CLEAR_BELOW = "\x1b[H", "\x1b[K", "\x1b[J"
HIDE_CURSOR, SHOW_CURSOR = "\x1b[?25l", "\x1b[?25h"
OTHER_SCREEN, OWN_SCREEN = "\x1b[?1049h", "\x1b[?1049l"
USUAL_SIZE = os.terminal_size((80, 24))  # of a terminal that does not know its own


class Terminal:
    """Standard input without line editing and echo, standard output as one live screen; Ctrl-C still interrupts.

    The screen is the terminal's alternate one: what was there before is there again afterwards, and nothing of it is
    left when the terminal changes its size.
    """

    def __init__(self) -> None:
        self._input = sys.stdin.fileno()
        self._before = termios.tcgetattr(self._input)
        self._shown: tuple[os.terminal_size, list[str]] | None = None

    def __enter__(self) -> Self:
        tty.setcbreak(self._input)
        sys.stdout.write(OTHER_SCREEN + HIDE_CURSOR)
        return self

    def __exit__(self, *error: object) -> None:
        termios.tcsetattr(self._input, termios.TCSADRAIN, self._before)
        sys.stdout.write(SHOW_CURSOR + OWN_SCREEN)
        sys.stdout.flush()

    @property
    def size(self) -> os.terminal_size:
        """Columns and lines, now."""
        size = os.get_terminal_size(sys.stdout.fileno())
        return size if size.columns and size.lines else USUAL_SIZE

    def read(self, timeout: float) -> bytes | None:
        """What was typed within `timeout` s; None when the terminal is gone."""
        ready, _, _ = select.select([self._input], [], [], timeout)
        if not ready:
            return b""
        return os.read(self._input, 1024) or None

    def show(self, lines: Sequence[str]) -> None:
        """Write the screen again, if it has changed; lines that do not fit into the terminal are cut."""
        size = self.size
        fitting = [line[: size.columns] for line in lines[: size.lines]]
        if self._shown == (size, fitting):
            return
        self._shown = size, fitting
        sys.stdout.write(HOME + "\n".join(line + CLEAR_LINE for line in fitting) + CLEAR_BELOW)
        sys.stdout.flush()

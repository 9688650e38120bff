"""`acromovi navigate watch`: show the state, map and log of a mission in the terminal."""

import argparse
import asyncio
import shutil
import sys
import time
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from math import pi
from typing import TYPE_CHECKING, Any

from acromovi.navigation.log import line, messages
from acromovi.navigation.standing import lines
from acromovi.options import add_bus
from acromovi.subcommand import Subcommand

if TYPE_CHECKING:
    from agents.platform import Agent, AgentName
    from bus.bus import Bus

PERIOD = 0.5  # s between two pictures
MAX_MESSAGES = 6
HOME, CLEAR_REST, CLEAR_TO_END_OF_LINE = "\x1b[H", "\x1b[J", "\x1b[K"
ALTERNATE, NORMAL = "\x1b[?1049h\x1b[?25l", "\x1b[?25h\x1b[?1049l"  # alternate screen and the normal one
MARKS = " ·█"  # by cell value: unknown, free, obstacle
COMPASS = "→↗↑↖←↙↓↘"
EPILOG = """\
example:
  acromovi navigate watch happy

In the map █ is an obstacle, · free floor, an arrow the robot, + the plan, D a door, X the goal. Ctrl-C ends the
display; the mission continues.

Exit codes: 1 the navigation does not run, or no terminal (the reason is on stderr), 130 stopped by Ctrl-C.
"""


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("robot", metavar="ROBOT", help="its name on the bus")
    add_bus(parser)


def _run(arguments: argparse.Namespace) -> int:
    """Show the mission until Ctrl-C; return the exit code."""
    from acromovi.navigation.components import RunningNavigation
    from bus.session import ZenohBus

    if not sys.stdout.isatty():
        print("acromovi navigate watch: this needs a terminal; use state or log without one", file=sys.stderr)
        return 1
    with ZenohBus.open(arguments.bus) as bus:
        interface = RunningNavigation(bus, arguments.robot).expect()
        sys.stdout.write(ALTERNATE)
        try:
            asyncio.run(_follow(bus, interface))
        finally:
            sys.stdout.write(NORMAL)
            sys.stdout.flush()
    return 0


async def _follow(bus: "Bus", interface: "AgentName") -> None:
    """Show the mission without end."""
    from acromovi.ask import asker
    from acromovi.navigation.components import REPLY_TIMEOUT

    log: deque[str] = deque(maxlen=MAX_MESSAGES)
    async with asker(bus, interface) as agent:
        hearing = asyncio.ensure_future(_hear(agent, interface, log))
        try:
            while True:
                begun = time.monotonic()
                outcome = await agent.request(interface, "picture", reply_within=REPLY_TIMEOUT)
                told = outcome.result if outcome.is_done else {}
                trouble = "" if outcome.is_done else f"{outcome.ending}: {outcome.why}"
                _show(page(interface.platform, told, log, trouble, shutil.get_terminal_size()))
                await asyncio.sleep(max(PERIOD - (time.monotonic() - begun), 0.1))
        finally:
            hearing.cancel()
            await asyncio.gather(hearing, return_exceptions=True)  # it was cancelled


async def _hear(agent: "Agent", interface: "AgentName", log: deque[str]) -> None:
    async for message in messages(agent, interface):
        log.append(line(message))


def _show(rows: Sequence[str]) -> None:
    sys.stdout.write(HOME + "\n".join(f"{row}{CLEAR_TO_END_OF_LINE}" for row in rows) + CLEAR_REST)
    sys.stdout.flush()


def page(robot: str, told: Mapping[str, Any], log: Sequence[str], trouble: str, size: tuple[int, int]) -> list[str]:
    """Return the lines of the display, for a size of so many columns and rows."""
    columns, rows = size
    head = [f"{robot}  {trouble}"] if trouble else [f"{robot}  {next(lines(told))}", *list(lines(told))[1:]]
    room = rows - len(head) - len(log) - 3
    shown = [*head, "", *floor_map(told, columns, room), "", *log]
    return [row[:columns] for row in shown][:rows]


def floor_map(told: Mapping[str, Any], columns: int, rows: int) -> Iterator[str]:
    """Yield the grid as text in so many columns and rows; a character is twice as high as wide."""
    from acromovi.navigation.mission_picture import floor_of

    grid = told.get("grid") or {}
    floor = floor_of(grid)
    if not floor.size or rows < 1:
        return
    high = max(-(-floor.shape[0] // rows), -(-floor.shape[1] * 2 // max(columns, 1)), 2)  # cells per row of text
    wide = max(high // 2, 1)
    drawn = [
        [MARKS[int(floor[row : row + high, column : column + wide].max())] for column in range(0, floor.shape[1], wide)]
        for row in range(0, floor.shape[0], high)
    ]
    for mark, x, y in _marks(told):
        row = int((y - grid["y"]) / grid["resolution"] // high)
        column = int((x - grid["x"]) / grid["resolution"] // wide)
        if 0 <= row < len(drawn) and 0 <= column < len(drawn[0]):
            drawn[row][column] = mark
    yield from ("".join(letters).rstrip() for letters in reversed(drawn))


def _marks(told: Mapping[str, Any]) -> Iterator[tuple[str, float, float]]:
    """Yield marks and their places; the last one is on top."""
    yield from (("D", door["x"], door["y"]) for door in told.get("doors", ()) if door.get("is_believed", True))
    yield from (("+", x, y) for x, y in (told.get("route") or ())[1:])
    goal = told.get("goal") or {}
    if goal.get("x") is not None and goal.get("y") is not None:
        yield "X", goal["x"], goal["y"]
    if told.get("pose"):
        x, y, heading = told["pose"]
        yield COMPASS[round(heading / (pi / 4)) % 8], x, y


COMMAND = Subcommand(EPILOG, _add_arguments, _run)

"""`acromovi wire PORT|FILE`: print the frames on a robot's cable."""

import argparse
import contextlib
import json
import sys
import time
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TextIO

import configs
from acromovi.subcommand import Subcommand
from configs.defaults import ROBOT
from gateway.errors import GatewayError
from gateway.serial_port import Port, open_port
from p2os import PARTIAL_TIMEOUT, RobotModel
from p2os.wire_log import FrameSource, WireLog, WireLogEntry
from p2os_emu.links.link import Link, PortError
from p2os_emu.links.poller import Poller
from p2os_emu.links.pty import PtyLink
from p2os_emu.links.tcp import TcpLink
from p2os_emu.recording import LineRecorder, RecordingError, read

GLANCE = 0.01
"""Seconds between two looks at the client's baud rate, and at a silent line."""
EPILOG = """\
examples:
  acromovi wire drive.jsonl                          a recording, frame by frame
  acromovi wire drive.jsonl --json | jq .name        one JSON object a line
  acromovi wire /dev/ttyUSB0 --listen /tmp/tapped    between a robot and its client, which opens /tmp/tapped
  acromovi wire /dev/ttyUSB0 --listen 8101 --record drive.jsonl
                                                     likewise on TCP port 8101, and keep what flows
  acromovi wire /dev/ttyUSB0                         what a robot says that somebody else left connected

A line has two ends and no third, so a live line is read by standing in it: the robot's port is opened here, and the
client opens what --listen offers. Bytes go both ways untouched, and the client's baud rate is set on the robot's port.

With --json a line is {"t": s, "from": "host"|"robot", "name": NAME, "fields": {...}, "problem": WHY, "hex": BYTES},
fields in SI; "problem" is there for damaged frames and unknown content only; "hex" is the payload of a sound frame.

Exit codes: 0 the recording ended, 1 the port or file cannot be used or was lost, 2 wrong usage, 130 stopped by Ctrl-C.
"""


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("line", metavar="PORT|FILE", help="port of the robot, or a recording")
    parser.add_argument("--listen", metavar="PATH|TCP", help="offer the robot to a client at a path or a TCP port")
    parser.add_argument("--json", action="store_true", help="print one JSON object a line")
    parser.add_argument(
        "--record", type=Path, metavar="FILE", help="record the live line; an existing file is an error"
    )
    parser.add_argument("--force", action="store_true", help="let --record overwrite an existing file")
    parser.add_argument(
        "--model",
        metavar="MODEL",
        help=f"set the model, for the scales [that of the robot, {ROBOT} until it answers]",
    )


def _run(arguments: argparse.Namespace) -> int:
    """Print until the recording or the line ends."""
    show = _printer(arguments.json, sys.stdout)
    try:
        if Path(arguments.line).is_file():
            replay(Path(arguments.line), arguments.model, show)
        else:
            _listen(arguments, show)
    except (RecordingError, GatewayError, PortError) as error:
        print(f"acromovi wire: {error}", file=sys.stderr)
        return 1
    return 0


def replay(path: Path, model: str | None, show: Callable[[Iterable[WireLogEntry]], None]) -> None:
    """Show a recording.

    Args:
        path: A recording.
        model: Gives the scales, also where the robot says something else; None leaves that to the recording.
        show: Takes what is found, in the order of the line.
    Raises:
        RecordingError: It cannot be read.
        ConfigError: There is no such model.
    """
    recording = read(path)
    log = _wire_log(model, recording.model)
    for moment in recording.moments:
        show(log.receive(moment.source, moment.data, moment.time))
    end = recording.moments[-1].time + 2 * PARTIAL_TIMEOUT
    for source in FrameSource:
        show(log.receive(source, b"", end))


class Tap:
    """Sits between a robot's port and a client, passes the bytes on and logs them.

    Args:
        port: The robot's.
        link: The client's; None if nobody is to come.
        log: Takes both directions.
        show: Takes what is found.
        keep: Also takes the bytes, as `Line.tap` does.
    """

    def __init__(
        self,
        port: Port,
        link: Link | None,
        log: WireLog,
        show: Callable[[Iterable[WireLogEntry]], None],
        keep: Callable[[float, str, bytes], None] | None = None,
    ) -> None:
        self._port = port
        self._link = link
        self._log = log
        self._show = show
        self._keep = keep

    def from_robot(self, now: float) -> None:
        """Take what the robot's port has; raises PortLost when it is gone."""
        data = self._port.read()
        if data and self._link is not None:
            self._link.write(data)
        self._note(FrameSource.ROBOT, data, now)

    def pass_time(self, now: float) -> None:
        """Take what the client has written, at the rate it has set, and give up half frames; call it often."""
        self._from_client(now)
        for source in FrameSource:
            self._show(self._log.receive(source, b"", now))

    def _from_client(self, now: float) -> None:
        if self._link is None:
            return
        data = self._link.read()
        if self._link.client_baud is not None:
            self._port.set_rate(self._link.client_baud)
        if data:
            self._port.write(data)
        self._note(FrameSource.HOST, data, now)

    def _note(self, source: FrameSource, data: bytes, now: float) -> None:
        if data and self._keep is not None:
            self._keep(now, source.value, data)
        self._show(self._log.receive(source, data, now))


def _listen(arguments: argparse.Namespace, show: Callable[[Iterable[WireLogEntry]], None]) -> None:
    with contextlib.ExitStack() as stack:
        port = open_port(arguments.line)
        stack.callback(port.close)
        poller = stack.enter_context(contextlib.closing(Poller()))
        link = _offer(arguments.listen, poller)
        if link is not None:
            stack.callback(link.close)
            print(f"acromovi wire: the client opens {link.port}", file=sys.stderr, flush=True)
        keep = None
        if arguments.record is not None:
            keep = stack.enter_context(
                contextlib.closing(LineRecorder(arguments.record, "", arguments.model or "", force=arguments.force))
            )
        tap = Tap(port, link, _wire_log(arguments.model, ""), show, keep)
        start = time.monotonic()
        poller.watch(port.fileno(), lambda events: tap.from_robot(time.monotonic() - start))
        while True:
            poller.poll(GLANCE)
            tap.pass_time(time.monotonic() - start)


def _offer(where: str | None, poller: Poller) -> Link | None:
    if where is None:
        return None
    return TcpLink(poller, int(where)) if where.isdecimal() else PtyLink(poller, Path(where))


def _wire_log(given: str | None, recorded: str) -> WireLog:
    """A log by the model given, else by the one recorded until the robot says what it is."""
    if given is not None:
        return WireLog(configs.load(RobotModel, "robots", given))
    first = _find_model(recorded) if recorded else None
    return WireLog(first or configs.load(RobotModel, "robots", ROBOT), _find_model)


def _find_model(subtype: str) -> RobotModel | None:
    if subtype not in (Path(name).stem for name in configs.names("robots")):
        return None
    return configs.load(RobotModel, "robots", subtype)


def _printer(as_objects: bool, output: TextIO) -> Callable[[Iterable[WireLogEntry]], None]:
    def show(entries: Iterable[WireLogEntry]) -> None:
        for entry in entries:
            print(json.dumps(entry.as_json(), ensure_ascii=False) if as_objects else entry.as_text(), file=output)
        output.flush()

    return show


COMMAND = Subcommand(EPILOG, _add_arguments, _run)

"""`acromovi record`: record robots and agents into an MCAP file."""

import argparse
import json
import sys
import time
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from acromovi.options import add_bus, count, seconds
from acromovi.subcommand import Subcommand
from configs.extras import require

if TYPE_CHECKING:
    from recorder.recorder import Recorder
    from recorder.recording import McapRecording
    from recorder.writer import RecordingWriter

MEGABYTE = 1_000_000
LOOK = 0.2  # s between two looks at the recorder
PROGRESS = 1.0  # s between two lines of progress
EPILOG = """\
examples:
  acromovi record                              everything, into recording-DATE-TIME.mcap, until Ctrl-C
  acromovi record happy --output drive.mcap    everything of one robot
  acromovi record '*/odom' '*/scan' --seconds 60
  acromovi record --split-size 500 --split-time 600
  acromovi record --info drive.mcap            what is in a recording

A key is an expression (* is one chunk, ** any number of chunks), or the name of a robot for all of its keys. The files
are read by acromovi replay, acromovi plot, and by other programs for MCAP files. What was written more than a second
ago stays readable, however the recorder ends. With --json the end is one line:
{"files": [FILE, ...], "messages": N, "bytes": N, "seconds": S, "lost": N, "error": TEXT or null}, and that of --info
{"files": [...], "start": S, "seconds": S, "messages": N, "channels": [{"key", "type", "encoding", "count"}, ...],
"notes": [...]}.

Exit codes: 0 recorded until Ctrl-C or --seconds, 1 ended by an error such as a full disk (what was written is kept), or
messages were lost, 2 wrong usage, 143 stopped by SIGTERM (the file is complete).
"""


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("keys", metavar="KEY", nargs="*", help="keys, or names of robots [everything]")
    parser.add_argument("--output", type=Path, metavar="FILE", help="set the file [recording-DATE-TIME.mcap]")
    parser.add_argument("--split-size", type=count, metavar="MB", help="begin a new file after MB megabytes [never]")
    parser.add_argument("--split-time", type=seconds, metavar="S", help="begin a new file after S seconds [never]")
    parser.add_argument("--seconds", type=seconds, metavar="S", help="end after S seconds [at Ctrl-C]")
    parser.add_argument("--info", type=Path, metavar="FILE", nargs="+", help="print what is in a recording, and end")
    parser.add_argument("--json", action="store_true", help="print one JSON object at the end")
    parser.add_argument("--quiet", action="store_true", help="print errors only")
    add_bus(parser)


def _run(arguments: argparse.Namespace) -> int:
    """Record until an end, or print what is in a recording."""
    require("recording", "recorder")
    if arguments.info:
        from recorder.recording import McapRecording

        with McapRecording.open(arguments.info) as recording:
            _show(recording, arguments.json)
        return 0
    return _record(arguments)


def _record(arguments: argparse.Namespace) -> int:
    from importlib.metadata import PackageNotFoundError, version

    from bus.session import ZenohBus
    from recorder.recorder import Recorder, expression_of
    from recorder.writer import RecordingWriter

    expressions = [expression_of(each) for each in arguments.keys or ["**"]]
    try:
        library = f"acromovi {version('acromovi')}"
    except PackageNotFoundError:  # run from a checkout
        library = "acromovi"
    path = arguments.output or Path(time.strftime("recording-%Y%m%d-%H%M%S.mcap"))
    with ZenohBus.open(arguments.bus) as bus:
        try:
            writer = RecordingWriter(
                path,
                library,
                {"keys": " ".join(expressions)},
                arguments.split_size and arguments.split_size * MEGABYTE,
                arguments.split_time and int(arguments.split_time * 1e9),
            )
        except OSError as err:
            what = "exists already; choose another --output" if isinstance(err, FileExistsError) else err.strerror
            print(f"acromovi record: {path}: {what}", file=sys.stderr)
            return 1
        begun = time.monotonic()
        recorder = Recorder(bus, expressions, writer)
        with recorder, suppress(KeyboardInterrupt):  # the usual end
            _watch(recorder, writer, arguments, begun)
    return _report(recorder, writer, arguments, time.monotonic() - begun)


def _watch(recorder: "Recorder", writer: "RecordingWriter", arguments: argparse.Namespace, begun: float) -> None:
    """Show the progress until the recording is to end."""
    shown = begun
    if not arguments.quiet and not arguments.json:
        print(f"recording into {writer.files[0]}; Ctrl-C ends it", flush=True)
    while not recorder.ended.wait(LOOK):
        now = time.monotonic()
        if arguments.seconds is not None and now - begun >= arguments.seconds:
            return
        if sys.stderr.isatty() and not arguments.quiet and now - shown >= PROGRESS:
            shown = now
            text = f"{now - begun:.0f} s, {writer.messages} messages, {writer.size / MEGABYTE:.1f} MB"
            print(f"\r{text}{_lost(recorder)}\x1b[K", end="", file=sys.stderr, flush=True)


def _report(recorder: "Recorder", writer: "RecordingWriter", arguments: argparse.Namespace, duration: float) -> int:
    """Print what was recorded; return the exit code."""
    if sys.stderr.isatty() and not arguments.quiet:
        print("\r\x1b[K", end="", file=sys.stderr)
    why = None if recorder.error is None else _reason(recorder.error, writer.files[-1])
    if arguments.json:
        record = {
            "files": [str(each) for each in writer.files],
            "messages": writer.messages,
            "bytes": writer.size,
            "seconds": round(duration, 3),
            "lost": recorder.lost,
            "error": why,
        }
        print(json.dumps(record))
    elif not arguments.quiet:
        names = ", ".join(map(str, writer.files))
        print(
            f"recorded {writer.messages} messages, {writer.size / MEGABYTE:.1f} MB in {duration:.0f} s into {names}"
            + _lost(recorder)
        )
    if why is not None:
        print(f"acromovi record: {why}", file=sys.stderr)
    return 1 if why is not None or recorder.lost else 0


def _lost(recorder: "Recorder") -> str:
    return f"; {recorder.lost} messages lost, since the disk is too slow" if recorder.lost else ""


def _reason(error: OSError, path: Path) -> str:
    if isinstance(error, FileExistsError):
        return f"{error.filename} exists already, so the recording ended with {path}"
    return f"the recording ended: {path} cannot become longer ({error.strerror}); what was written before is complete"


def _show(recording: "McapRecording", as_json: bool) -> None:
    """Print what is in a recording."""
    record: dict[str, Any] = {
        "files": [str(each) for each in recording.paths],
        "start": recording.start_ns / 1e9,
        "seconds": recording.duration,
        "messages": sum(each.count for each in recording.channels),
        "channels": [
            {"key": each.key, "type": each.type_name, "encoding": each.encoding, "count": each.count}
            for each in recording.channels
        ],
        "notes": recording.notes,
    }
    if as_json:
        print(json.dumps(record))
        return
    start = time.strftime("%Y-%m-%d %H:%M:%S", time.localtime(record["start"]))
    print(f"{', '.join(record['files'])}: {record['messages']} messages in {record['seconds']:.1f} s from {start}")
    keys = [_plain(each["key"]) for each in record["channels"]]
    types = [_plain(each["type"] or each["encoding"]) for each in record["channels"]]
    for key, type_name, channel in zip(keys, types, record["channels"], strict=True):
        rate = channel["count"] / recording.duration if recording.duration else 0.0
        print(
            f"{key:<{max(map(len, keys))}}  {type_name:<{max(map(len, types))}}  {channel['count']:>7}  {rate:6.1f} Hz"
        )
    for note in recording.notes:
        print(_plain(note))


def _plain(text: str) -> str:
    """A text of a file without what would move the cursor of a terminal."""
    return "".join(each if each.isprintable() else "?" for each in text)


COMMAND = Subcommand(EPILOG, _add_arguments, _run)

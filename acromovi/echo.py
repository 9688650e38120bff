"""`acromovi echo`: print the messages on a key."""

import argparse
import json
import queue
import sys
from datetime import datetime
from typing import TYPE_CHECKING, Any, TextIO

from acromovi.options import add_bus, count, seconds
from acromovi.subcommand import Subcommand

if TYPE_CHECKING:
    from bus.bus import Bus, Sample

SILENCE = 3.0  # s without a message until a hint is given
EPILOG = """\
examples:
  acromovi echo happy/odom
  acromovi echo happy/battery --json --count 1
  acromovi echo '*/odom'                     every robot's odometry
  acromovi echo 'happy/**' --timeout 5       everything of one robot; fail when it is silent for 5 s

With --json each message is one line: {"key": KEY, "type": TYPE, "stamp_ns": NS, "message": {...}}, where stamp_ns is
the header's stamp or null, infinity and NaN are the strings "inf", "-inf" and "nan", and bytes are base64. A payload
that cannot be decoded has "message": null with its "bytes" (how many) and the "error".

Exit codes: 0 COUNT messages were printed, 1 silence for TIMEOUT seconds, 130 stopped by Ctrl-C.
"""


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("key", metavar="KEY", help="a key, or an expression: * is one chunk, ** any number of chunks")
    parser.add_argument("--json", action="store_true", help="print one JSON object a line")
    parser.add_argument("--count", type=count, metavar="N", help="end after N messages")
    parser.add_argument("--timeout", type=seconds, metavar="S", help="fail when no message arrives for S seconds")
    add_bus(parser)


def _run(arguments: argparse.Namespace) -> int:
    """Print messages until the count, the timeout or Ctrl-C."""
    from bus.session import ZenohBus

    with ZenohBus.open(arguments.bus) as bus:
        return echo(bus, arguments.key, arguments.json, arguments.count, arguments.timeout)


def echo(
    bus: "Bus",
    key: str,
    as_json: bool = False,
    count: int | None = None,
    timeout: float | None = None,
    output: TextIO | None = None,
) -> int:
    """Print the messages on a key.

    Args:
        bus: Where to listen.
        key: A key or an expression.
        as_json: One JSON object a line, in place of text.
        count: End after so many messages; None goes on for ever.
        timeout: s without a message after which to give up; None waits for ever, but says so once.
        output: Where to print; None is standard output.
    Returns:
        The exit code.
    """
    from acromovi.presence import RobotPresence

    presence = RobotPresence(bus)
    arrived: queue.SimpleQueue[Sample] = queue.SimpleQueue()
    printed = 0
    with bus.subscribe(key, arrived.put):
        while count is None or printed < count:
            try:
                sample = arrived.get(timeout=timeout if timeout or printed else SILENCE)
            except queue.Empty:
                print(f"acromovi echo: nothing on {key}; {_hint(key, presence.robots)}", file=sys.stderr)
                if timeout:
                    return 1
                sample = arrived.get()
            line = json.dumps(record(sample), ensure_ascii=False) if as_json else text(sample)
            print(line, file=output, flush=True)
            printed += 1
    return 0


def record(sample: "Sample") -> dict[str, Any]:
    """A sample as `--json` prints it; the help text describes it."""
    from bus.bus import JSON
    from bus.errors import MessageError
    from bus.messages import decode, decode_json, stamp_ns, to_json

    type_name = type_of(sample)
    result: dict[str, Any] = {"key": sample.key, "type": type_name or sample.encoding, "stamp_ns": None}
    try:
        if type_name == JSON:
            return result | {"message": decode_json(sample.payload)}
        message = decode(type_name, sample.payload)
    except MessageError as err:
        return result | {"message": None, "bytes": len(sample.payload), "error": str(err)}
    stamp = stamp_ns(message.header) if hasattr(message, "header") else None
    return result | {"stamp_ns": stamp, "message": to_json(message)}


def type_of(sample: "Sample") -> str:
    """Return the type by the encoding, else by the table of keys, else None."""
    from bus.bus import JSON
    from bus.keys import topic_of

    if sample.type_name or sample.encoding == JSON:
        return sample.type_name or JSON
    topic = topic_of(sample.key)
    return topic.type_name if topic else ""


def text(sample: "Sample") -> str:
    """Return a sample as text: a head line, then a line for each field."""
    shown = record(sample)
    head = f"--- {shown['key']}  {shown['type']}"
    if shown["stamp_ns"] is not None:
        head += f"  {datetime.fromtimestamp(shown['stamp_ns'] / 1e9):%H:%M:%S.%f}"
    if shown["message"] is None:
        return f"{head}\n{shown['bytes']} bytes: {shown['error']}"
    return "\n".join([head, *_lines(shown["message"], "")])


def _lines(value: Any, indent: str) -> list[str]:
    """Objects as indented lines, lists of plain values on one line."""
    lines = []
    items = value.items() if isinstance(value, dict) else ((f"- {i}", item) for i, item in enumerate(value))
    for name, item in items:
        if isinstance(item, dict) or (isinstance(item, list) and any(isinstance(each, dict) for each in item)):
            lines += [f"{indent}{name}:", *_lines(item, indent + "  ")]
        else:
            lines.append(f"{indent}{name}: {_plain(item)}")
    return lines


def _plain(value: Any) -> str:
    if isinstance(value, list):
        return "[" + ", ".join(_plain(item) for item in value) + "]"
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _hint(key: str, robots: list[str]) -> str:
    """Return why a key may have no messages."""
    import difflib

    from acromovi.presence import advice
    from bus.keys import TOPICS, Kind, split, topic_of

    robot, suffix = split(key)
    topic = topic_of(key)
    if "*" not in robot and robot not in robots:
        return advice(robot, robots)
    if topic is not None and topic.kind is Kind.QUERY:
        return "programs ask there and get an answer; nothing is published"
    if topic is not None and topic.kind is Kind.COMMAND:
        return "programs command the robot there, and none does now"
    near = difflib.get_close_matches(suffix, [topic.suffix for topic in TOPICS if topic.kind is Kind.STREAM], 1)
    if topic is None and "*" not in suffix and near:
        return f"did you mean {robot}/{near[0]}?"
    return "see what flows with acromovi topics"


COMMAND = Subcommand(EPILOG, _add_arguments, _run)

"""`acromovi sniff`: print the messages between agents."""

import argparse
import json
import shutil
import sys
import time
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from acromovi.options import add_bus, seconds
from acromovi.subcommand import Subcommand

if TYPE_CHECKING:
    from acromovi.known_agents import KnownAgents
    from acromovi.sniffer.listener import Listener
    from acromovi.sniffer.sequence import Diagram
    from agents.sniffer.captured import CapturedMessage, Heard

SILENCE = 3.0  # s without a word until a hint is given
LOOK = 0.05  # s between two looks at what has come
MOST_DRAWN = 500  # messages in a diagram
LONGEST_CONTENT = 100  # characters on a line
WHO = 34  # characters for who speaks to whom; more where names are longer
EPILOG = """\
examples:
  acromovi sniff                                 all that agents say to each other
  acromovi sniff base@happy 'app-*'              what these say and hear
  acromovi sniff --conversation 8c1d0a           one conversation, by the beginning of its id
  acromovi sniff --seconds 10 --diagram          a sequence diagram in the end
  acromovi sniff '*@happy' --svg talk.svg        the same as a picture, for a browser; Ctrl-C ends it
  acromovi sniff --json

A line has the time, the conversation, who speaks to whom, the act, and the content. Messages come in the order in which
they were said, by the clocks of the machines where their containers are. A diagram shows the last 500. Results streams
are no messages: acromovi echo '*/agents/*/results' shows them.

With --json each message is one line: {"time": S, "container": NAME, "message": {"performative": ..., "sender": ...,
"receivers": [...], "content": ..., "conversation_id": ..., ...}}, where S is s since 1970. What cannot be read has
"message": null with its "bytes" (how many) and the "error".

Exit codes: 0 SECONDS have passed, also when nothing was said, 1 the bus cannot be reached or the file cannot be
written, 2 wrong usage, 130 stopped by Ctrl-C.
"""


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "agents", metavar="AGENT", nargs="*", help="print only messages of these agents; * matches any letters"
    )
    parser.add_argument(
        "--conversation", metavar="ID", help="print only this conversation; the beginning of its id is enough"
    )
    parser.add_argument("--seconds", type=seconds, metavar="S", help="end after S seconds [with Ctrl-C]")
    parser.add_argument("--diagram", action="store_true", help="print a sequence diagram in the end")
    parser.add_argument("--svg", type=new_file, metavar="FILE", help="write a sequence diagram as SVG in the end")
    parser.add_argument("--json", action="store_true", help="print one JSON object a line")
    add_bus(parser)


def new_file(text: str) -> Path:
    """A file that can be written, as far as can be seen before it is."""
    path = Path(text).expanduser()
    if path.is_dir():
        raise argparse.ArgumentTypeError(f"{text} is a folder")
    if not path.parent.is_dir():
        raise argparse.ArgumentTypeError(f"there is no folder {path.parent}")
    return path


def _run(arguments: argparse.Namespace) -> int:
    """Listen until the time is over or Ctrl-C, then draw."""
    from acromovi.known_agents import KnownAgents
    from acromovi.sniffer.listener import Listener
    from agents.sniffer.captured import wanted
    from bus.session import ZenohBus

    if arguments.json and arguments.diagram:
        print("acromovi sniff: --json and --diagram both print; --svg FILE goes with --json", file=sys.stderr)
        return 2
    transcript = _Transcript(wanted(arguments.agents, arguments.conversation), arguments.json)
    is_drawn = True
    with ZenohBus.open(arguments.bus) as bus, KnownAgents(bus) as known, Listener(bus) as ear:

        def tell_silence() -> None:
            print(f"acromovi sniff: nothing has been said; {_advice(arguments.agents, known)}", file=sys.stderr)

        try:
            _follow(ear, transcript, arguments.seconds, tell_silence)
        finally:
            transcript.add(ear.rest())
            is_drawn = _draw(transcript, arguments.diagram, arguments.svg)
    return 0 if is_drawn else 1


class _Transcript:
    """Prints messages, and keeps the latest for the diagrams.

    count: messages that were printed and can be drawn.
    """

    def __init__(self, is_wanted: "Callable[[Heard], bool]", as_json: bool) -> None:
        self.count = 0
        self._is_wanted = is_wanted
        self._as_json = as_json
        self._last: deque[CapturedMessage] = deque(maxlen=MOST_DRAWN)

    def add(self, heard: "Iterable[Heard]") -> None:
        """Print what is wanted of it."""
        from agents.sniffer.captured import CapturedMessage

        for each in filter(self._is_wanted, heard):
            shown = json.dumps(each.record()) if self._as_json else _line(each)
            print(shown, flush=True)
            if isinstance(each, CapturedMessage):
                self.count += 1
                self._last.append(each)

    def diagram(self) -> "Diagram":
        """The last of it."""
        from acromovi.sniffer.sequence import diagram_of

        return diagram_of(self._last, self.count - len(self._last))


def _follow(ear: "Listener", transcript: _Transcript, duration: float | None, on_silence: Callable[[], None]) -> None:
    """Print messages for a time, s, or without end; give advice once when there are none."""
    begun = time.monotonic()
    quiet_until = begun + min(SILENCE, duration or SILENCE)
    while duration is None or time.monotonic() < begun + duration:
        transcript.add(ear.heard(LOOK))
        if not transcript.count and time.monotonic() >= quiet_until:
            on_silence()
            quiet_until = float("inf")


def _advice(patterns: Sequence[str], known: "KnownAgents") -> str:
    """Return advice for when there are no messages."""
    from agents.sniffer.captured import matches

    if not known.names:
        return "there are no agents: start a team with acromovi up, and see whether both use the same --bus"
    if patterns and not any(matches(name, patterns) for name in known.names):
        return f"none of the agents here is called {' or '.join(patterns)}; acromovi ps lists them"
    return "agents speak when there is something to do; acromovi ask gives them something"


def _line(heard: "Heard") -> str:
    """Something heard, for people."""
    from acromovi.sniffer.text import clock
    from agents.sniffer.captured import SHORT_ID, Unreadable, brief, shortened

    if isinstance(heard, Unreadable):
        return (
            f"{clock(heard.time)}  {heard.size} bytes of {heard.container} are unreadable: {shortened(heard.why, 200)}"
        )
    message = heard.message
    who = f"{message.sender} → {', '.join(map(str, message.receivers)) or 'nobody'}"
    text = brief(message.content, LONGEST_CONTENT)
    mark = shortened(message.conversation_id[:SHORT_ID], SHORT_ID)
    return f"{clock(heard.time)}  {mark:<{SHORT_ID}}  {who:<{WHO}}  {message.performative:<8} {text}".rstrip()


def _draw(transcript: _Transcript, as_text: bool, picture: Path | None) -> bool:
    """Print or write the diagram, as is wanted; False when the file cannot be written."""
    from acromovi.sniffer.svg import svg
    from acromovi.sniffer.text import lines

    diagram = transcript.diagram()
    if as_text:
        width = shutil.get_terminal_size((160, 24)).columns
        print("\n" + "\n".join(lines(diagram, width)), flush=True)
    if picture is not None:
        try:
            picture.write_text(svg(diagram), encoding="utf-8")
        except OSError as err:
            print(f"acromovi sniff: {picture} cannot be written: {err.strerror}", file=sys.stderr)
            return False
    return True


COMMAND = Subcommand(EPILOG, _add_arguments, _run)

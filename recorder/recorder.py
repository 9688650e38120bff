"""Records the bus: hears samples and tokens, asks new programs for their descriptions, writes both.

The threads of the bus only put what they hear into a queue. One thread writes it, ten times a second, so that a slow
disk delays no program and no message is lost while it waits.
"""

import threading
import time
from collections import deque
from collections.abc import Iterable
from functools import partial
from typing import Any, NamedTuple

from bus import keys
from bus.bus import Answer, Bus, Closeable, Sample
from bus.errors import BusError
from bus.exchange import key_expression
from recorder.writer import RecordingWriter

TURN = 0.1  # s between two turns of the writing thread
MOST_WAITING = 256 << 20  # bytes of samples that wait for a slow disk
DESCRIPTION_TIME = 5.0  # s for a program to describe itself
_SAMPLE_SIZE = 500  # bytes that a sample takes beside its payload
_ALIVE = "/alive"


class _Token(NamedTuple):
    key: str
    is_alive: bool


class _Standing(NamedTuple):
    key: str
    value: dict[str, Any]


class Recorder(Closeable):
    """Records what flows on keys until it is closed.

    lost: samples that were dropped, because the disk was too slow for more than `MOST_WAITING`.
    error: the error that ended the recording, for example a full disk; None while all is well.
    ended: set when an error has ended it.
    """

    def __init__(self, bus: Bus, expressions: Iterable[str], writer: RecordingWriter) -> None:
        """Begin.

        Args:
            bus: Where to listen.
            expressions: Keys, with wildcards; see `expression_of`.
            writer: It is closed with the recorder.
        Raises:
            BusError: One of them is no key, or this program may not listen there.
        """
        self.lost = 0
        self.error: OSError | None = None
        self.ended = threading.Event()
        self._bus = bus
        self._writer = writer
        self._offset_ns = time.time_ns() - time.monotonic_ns()
        self._waiting: deque[tuple[int, Sample | _Token | _Standing]] = deque()
        self._bytes_in = 0  # by the threads of the bus
        self._bytes_out = 0  # by the thread that writes
        self._expressions = [key_expression(each) for each in dict.fromkeys(expressions)]
        self._first: dict[str, int] = {}  # for each key the number of the first expression that matches it
        self._asking: dict[str, Closeable] = {}
        self._is_closing = threading.Event()
        self._open: list[Closeable] = []
        try:
            for index, each in enumerate(self._expressions):
                self._open.append(bus.subscribe(str(each), partial(self._hear, index), urgent=True))
            for tokens in {_tokens_of(str(each)) for each in self._expressions}:
                self._open.append(bus.watch_alive(tokens, self._note_token))
        except BusError:
            self._stop_listening()
            writer.close()
            raise
        self._thread = threading.Thread(target=self._run, name="recorder", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stop listening, write what waits, and end the file. Errors of the disk are in `error`."""
        self._stop_listening()
        self._is_closing.set()
        self._thread.join()

    def _stop_listening(self) -> None:
        while self._open:
            self._open.pop().close()

    def _now_ns(self) -> int:
        """Return ns since 1970 by the clock at the start: it never goes back, also if the clock is set."""
        return self._offset_ns + time.monotonic_ns()

    # On threads of the bus.

    def _hear(self, index: int, sample: Sample) -> None:
        if self._is_repeated(index, sample.key):
            return
        size = len(sample.payload) + _SAMPLE_SIZE
        if self._bytes_in - self._bytes_out + size > MOST_WAITING:
            self.lost += 1
            return
        self._bytes_in += size
        self._waiting.append((self._now_ns(), sample))

    def _is_repeated(self, index: int, key: str) -> bool:
        """Return whether an expression before this one matches the key, too."""
        if len(self._expressions) == 1:
            return False
        if key not in self._first:
            one = key_expression(key)
            self._first[key] = next(at for at, each in enumerate(self._expressions) if each.intersects(one))
        return self._first[key] != index

    def _note_token(self, key: str, is_alive: bool) -> None:
        self._waiting.append((self._now_ns(), _Token(key, is_alive)))

    # On the thread that writes.

    def _run(self) -> None:
        try:
            while not self._is_closing.wait(TURN):
                self._write_waiting()
                self._writer.flush(self._now_ns())
            while self._waiting:
                self._write_waiting()
            self._writer.close()
        except OSError as err:
            self.error = err
            self._writer.give_up(err)
        finally:
            self.ended.set()
            for asking in self._asking.values():
                asking.close()

    def _write_waiting(self) -> None:
        for _ in range(len(self._waiting)):
            time_ns, item = self._waiting.popleft()
            match item:
                case Sample():
                    self._bytes_out += len(item.payload) + _SAMPLE_SIZE
                    self._writer.add(item, time_ns)
                case _Token():
                    self._writer.add_token(item.key, item.is_alive, time_ns)
                    self._follow(item)
                case _Standing():
                    self._asking.pop(item.key, None)
                    self._writer.add_description(item.key, item.value, time_ns)
            self._writer.flush(time_ns)

    def _follow(self, token: _Token) -> None:
        """Ask a program that has appeared for what it only publishes on change."""
        for key in _standing_keys(token.key):
            if (asking := self._asking.pop(key, None)) is not None:
                asking.close()
            if token.is_alive:
                self._ask(key)

    def _ask(self, key: str) -> None:
        def keep(answer: Answer) -> None:
            self._waiting.append((self._now_ns(), _Standing(answer.key, answer.value)))

        try:
            self._asking[key] = self._bus.ask(key, None, keep, lambda error: None, DESCRIPTION_TIME, urgent=True)
        except BusError:  # the bus is closed, or does not let this program ask; the streams are recorded all the same
            return


def expression_of(text: str) -> str:
    """Return the key expression of an argument: a robot's name stands for all of its keys.

    Raises:
        KeyNotValid: It cannot be a robot's name, and is no expression.
    """
    if "/" in text or text == "**":
        return text
    return f"{text if '*' in text else keys.robot_name(text)}/**"


def _tokens_of(expression: str) -> str:
    """Return the expression of the tokens of those whose keys an expression matches."""
    platform = expression.partition("/")[0]
    return "**" if platform == "**" else f"{platform}/**"


def _standing_keys(token: str) -> list[str]:
    """Return the keys on which the program that shows a token tells of itself; an element is told of by its robot."""
    topic = keys.topic_of(token)
    robot, _ = keys.split(token)
    if topic is keys.ELEMENT_ALIVE:
        return [keys.DESCRIPTION.key(robot)]
    if topic is keys.ALIVE:
        return [keys.DESCRIPTION.key(robot), keys.LEASE_STATE.key(robot)]
    return [token.removesuffix(_ALIVE) + "/description"] if token.endswith(_ALIVE) else []

"""Mutated payloads on every key of a robot that receives something: nothing but refusals, and the robot still works.

Firmware, driver and gateway run in lockstep on a bus in memory. Requests are made from the tables of commands, so that
a new command is covered without a change here; most mutants stay JSON and reach the command itself.
"""

import contextlib
import json
import logging
import random
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, Self

from acromovi.lockstep import Lockstep
from bus import MemoryBus, NoAnswer, Refused, Sample, keys
from bus.exchange import RawReply, key_expression
from bus.messages import TwistStamped, encode, header, twist
from gateway.command_server import LEASE_ARGUMENTS
from gateway.commands import TOKEN, CommandRow
from gateway.elements.adapter import adapter_types
from gateway.elements.all_elements import ELEMENTS
from p2os_emu.world import load_world

PAYLOADS = 1_000_000
ROBOT = "fuzzed"
PARTS = "gripper,laser,ptz,gyro,compass,joystick"
MODEL = "p3dx-sh"
PER_STEP = 40
"""Payloads in one step of the emulation."""
PER_RESET = 2000
"""Payloads until leases and the e-stop are released, so that the later ones reach more than a refusal."""
SEED = 11

EXAMPLES: Mapping[type, Any] = {
    bool: True,
    int: 1,
    float: 0.1,
    str: "stop",
    list: [[60, 0.2]],
    dict: {"1": 0.1},
}
"""A proper argument of each type."""
WORDS = ("open", "move", "power", "take", "renew", "release", "show", "look", "base", "arm", "robot", f"{ROBOT}-1")
HOSTILE: tuple[Any, ...] = (
    *(None, True, False, 0, -1, 2**31, 2**63, -(2**63), 2**64, 10**300, 10**4000),
    *(0.5, -0.5, 1e-300, 5e-324, 1e300, float("inf"), float("-inf"), float("nan")),
    *("", " ", "\0", "\x1b[2J", "\ud800", "\udfff\ud800", "é", "日本", "\u202e", "a" * 201, "9" * 5000, "x" * 100_000),
    *([], {}, [[]], [[], {}], {"": ""}, {"\ud800": 1}, {"1": "\ud800"}, {"9" * 5000: 1.0}, [[60, 0.2]] * 30),
    *([[True, False]], [[1e400, -1]], [[60, float("nan")]], {"1": float("nan")}, {"0": 1}, {"1": True}, {"²": 1.0}),
)
"""Values that no argument should be."""
HOSTILE_PAYLOADS: tuple[bytes, ...] = (
    *(b"", b"null", b"[]", b'"x"', b"7", b"{", b"}", b'{"a":1}x', b"\xff\xfe\0{", b'{"a":"\xed\xa0\x80"}', b"\0"),
    *(b"[" * 100_000, b'{"a":' * 50_000, b'{"a":' + b"[" * 60 + b"]" * 60 + b"}", b'{"a":"' + b'\\"' * 50_000),
    *(
        b'{"do":' + b"9" * 100_000 + b"}",
        b'{"holder":"' + b"x" * 300_000 + b'"}',
        b'{"on":NaN}',
        b'{"linear":-Infinity}',
    ),
)
"""Payloads that are no request at all."""


@dataclass
class Outcome:
    """What became of the payloads.

    accepted, refused: queries by their replies. samples: messages on streams, which have no reply. failures: errors
    that are no refusal, and messages that the gateway could not publish.
    """

    accepted: int = 0
    refused: int = 0
    samples: int = 0
    failures: Counter[str] = field(default_factory=Counter)

    @property
    def count(self) -> int:
        """All of them."""
        return self.accepted + self.refused + self.samples


class FuzzedRobot:
    """One robot with accessories whose gateway receives whatever it is given."""

    def __init__(self) -> None:
        self._lockstep = Lockstep(load_world("empty"), {ROBOT: MODEL}, fits={ROBOT: PARTS})
        bus = self._lockstep.bus()
        assert isinstance(bus, MemoryBus)
        self._bus = bus
        self._heard: Counter[str] = Counter()
        self.outcome = Outcome()
        self._bus.subscribe(f"{ROBOT}/**", lambda sample: self._heard.update([sample.key]))
        self._watch = _FailureWatch(self.outcome.failures)
        self._lockstep.run(3.0)

    def __enter__(self) -> Self:
        self._watch.__enter__()
        return self

    def __exit__(self, *error: object) -> None:
        self._watch.__exit__()
        self._lockstep.close()

    def give(self, suffix: str, payload: bytes, attachment: bytes = b"") -> None:
        """Deliver one payload on one key, as a query or as a message."""
        key = f"{ROBOT}/{suffix}"
        if suffix in STREAMS:
            self._bus.deliver(Sample(key, payload, attachment=attachment))
            self.outcome.samples += 1
            return
        replies: list[RawReply] = []
        for entry in self._bus.network.queryables:
            if entry.matches(key_expression(key)):
                entry.call(payload, replies.append, lambda: None)
        if len(replies) != 1:
            self.outcome.failures[f"{len(replies)} replies on {suffix}"] += 1
        self.outcome.refused += any(reply.is_error for reply in replies)
        self.outcome.accepted += any(not reply.is_error for reply in replies)

    def run(self, seconds: float) -> None:
        """Let virtual time pass."""
        self._lockstep.run(seconds)

    def reset(self) -> None:
        """Release what the payloads have taken: leases by their end, the e-stop by a command."""
        for key, arguments in ((keys.ESTOP, {"on": False}), (keys.ENABLE, {"on": True})):
            with contextlib.suppress(Refused):  # somebody holds the lease; it ends by itself
                self._bus.query(key.key(ROBOT), arguments)

    def check(self) -> None:
        """See that the gateway still publishes, replies and has lost no message.

        Raises:
            AssertionError: It does not.
        """
        self._heard.clear()
        self.run(1.5)
        silent = [suffix for suffix in ("odom", "state", "diagnostics", "scan") if not self._heard[f"{ROBOT}/{suffix}"]]
        assert not silent, f"{ROBOT} does not publish {', '.join(silent)} any more"
        try:
            self._bus.query(keys.DESCRIPTION.key(ROBOT))
        except NoAnswer as error:
            raise AssertionError(f"{ROBOT} does not reply any more") from error
        assert not self.outcome.failures, f"errors that are no refusal: {dict(self.outcome.failures)}"


class _FailureWatch(logging.Handler):
    """Counts what bus and gateway log as errors: what a handler or a publisher has raised."""

    def __init__(self, failures: Counter[str]) -> None:
        super().__init__(logging.ERROR)
        self._failures = failures
        self._loggers = [logging.getLogger(name) for name in ("bus", "gateway")]

    def emit(self, record: logging.LogRecord) -> None:
        """Count one."""
        error = record.exc_info[1] if record.exc_info else None
        self._failures[f"{record.getMessage()}: {error!r}"[:500]] += 1

    def __enter__(self) -> None:
        for logger in self._loggers:
            logger.addHandler(self)
            logger.propagate = False

    def __exit__(self, *error: object) -> None:
        for logger in self._loggers:
            logger.removeHandler(self)
            logger.propagate = True


def rows() -> list[CommandRow]:
    """Every command that such a robot takes."""
    return [command for row in ELEMENTS for adapter in adapter_types(row) for command in adapter.commands]


def requests() -> list[tuple[str, dict[str, Any]]]:
    """A proper request on each key that takes one: suffix and arguments."""
    found: list[tuple[str, dict[str, Any]]] = [(keys.DESCRIPTION.suffix, {}), (keys.LEASE_STATE.suffix, {})]
    for row in rows():
        taken = {**row.takes, **row.may_take, TOKEN: str}
        found.append((row.topic.suffix, {name: EXAMPLES[kind] for name, kind in taken.items()}))
    for what, (takes, may_take) in LEASE_ARGUMENTS.items():
        taken = {**takes, **may_take}
        found.append((keys.LEASE.suffix, {"do": what, **{name: EXAMPLES[kind] for name, kind in taken.items()}}))
    return found


STREAMS: Mapping[str, bytes] = {
    keys.CMD_VEL.suffix: encode(twist(0.2, 0.1)),
    keys.CMD_VEL_STAMPED.suffix: encode(TwistStamped(header(0, "h"), twist(0.2, 0.1))),
}
"""A proper message on each key that carries CDR."""


def mutants(seed: int = SEED) -> Iterator[tuple[str, bytes, bytes]]:
    """Payloads without end: suffix, payload, attachment."""
    rng = random.Random(seed)
    proper, streams = requests(), list(STREAMS.items())
    while True:
        if rng.random() < 0.15:
            suffix, message = rng.choice(streams)
            token = rng.choice([b"", b"\xff\xfe", f"{ROBOT}-{rng.randrange(99)}".encode(), b"x" * 10_000])
            yield suffix, damaged(message, rng), token
            continue
        suffix, arguments = rng.choice(proper)
        match rng.random():
            case random_choice if random_choice < 0.02:
                yield suffix, rng.choice(HOSTILE_PAYLOADS), b""
            case random_choice if random_choice < 0.15:
                yield suffix, damaged(json.dumps(arguments).encode(), rng), b""
            case _:
                yield suffix, _written(mutated(arguments, rng), rng), b""


def mutated(arguments: Mapping[str, Any], rng: random.Random) -> dict[str, Any]:
    """A request with one argument replaced by a hostile value, or with several replaced, left out or added."""
    changed = dict(arguments)
    if arguments and rng.random() < 0.6:
        name = rng.choice(list(arguments))
        alike = [value for value in HOSTILE if type(value) is type(arguments[name])]
        changed[name] = rng.choice(alike if rng.random() < 0.8 else HOSTILE)
        if name != TOKEN:
            changed.pop(TOKEN, None)
        return changed
    for name in arguments:
        match rng.random():
            case random_choice if random_choice < 0.2:
                changed[name] = rng.choice(HOSTILE)
            case random_choice if random_choice < 0.4:
                changed[name] = rng.choice(WORDS)
            case random_choice if random_choice < 0.55:
                changed[name] = rng.uniform(-3.0, 3.0)
            case random_choice if random_choice < 0.75:
                del changed[name]
    if rng.random() < 0.1:
        changed[rng.choice(["do", "on", "", "\ud800", "x" * 1000])] = rng.choice(HOSTILE)
    return changed


def damaged(payload: bytes, rng: random.Random) -> bytes:
    """Bytes replaced, cut off or appended."""
    data = bytearray(payload)
    for _ in range(rng.randrange(4)):
        if data:
            data[rng.randrange(len(data))] = rng.choice([0, 0xFF, 0x7F, 0x80, rng.randrange(256)])
    match rng.random():
        case random_choice if random_choice < 0.2:
            del data[rng.randrange(len(data) + 1) :]
        case random_choice if random_choice < 0.4:
            data += rng.randbytes(rng.choice([1, 3, 8, 1000]))
    return bytes(data)


def _written(arguments: Mapping[str, Any], rng: random.Random) -> bytes:
    """JSON as a foreign program may write it: with escapes, or with raw bytes that are no UTF-8."""
    if rng.random() < 0.8:
        return json.dumps(arguments).encode()
    return json.dumps(arguments, ensure_ascii=False).encode("utf-8", "surrogatepass")


def feed(payloads: int, seed: int = SEED) -> Outcome:
    """Give a robot mutated payloads, and see that it works as before.

    Raises:
        AssertionError: An error was no refusal, or the gateway does not work any more.
    """
    with FuzzedRobot() as robot:
        for number, (suffix, payload, attachment) in enumerate(mutants(seed), 1):
            robot.give(suffix, payload, attachment)
            if number % PER_STEP == 0:
                robot.run(1 / 120)
            if number % PER_RESET == 0:
                robot.reset()
            if number == payloads:
                break
        robot.check()
        return robot.outcome

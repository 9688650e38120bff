"""Whatever comes on any key, the gateway refuses it or obeys it, and works as before."""

import json
import logging
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from acromovi.children import emulator, gateway
from benchmarks import fuzz_bus
from benchmarks.fuzz_bus import HOSTILE, HOSTILE_PAYLOADS, STREAMS, FuzzedRobot
from bus import Bus, ZenohBus, keys, memory
from bus.validation import LONGEST_NAME
from gateway.settings import Settings
from tests.gateway.test_robot_on_bus import Office
from tests.waiting import patience, wait_until

if TYPE_CHECKING:
    from tests.gateway.conftest import Bench

LIMIT = 15.0
"""Seconds for a reply: only a failing test waits so long."""
REQUESTS = fuzz_bus.requests()
CHARACTERS = st.characters(exclude_categories=())  # surrogates too
ANYTHING = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.text(CHARACTERS, max_size=30)
    | st.sampled_from(HOSTILE),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(CHARACTERS, max_size=8), inner, max_size=3),
    max_leaves=6,
)


@pytest.fixture
def office(bench: "Bench") -> Office:
    return Office(bench, Settings())


@pytest.fixture(scope="module")
def fuzzed() -> Iterator[FuzzedRobot]:
    with FuzzedRobot() as robot:
        yield robot


def hold(office: Office, holder: str) -> str:
    return office.refusal("lease", do="take", holder=holder, seconds=5.0)


def diagnosed(office: Office, part: str) -> dict[str, str]:
    (status,) = [each for each in office.last("diagnostics").status if each.name == f"happy: {part}"]
    return {value.key: value.value for value in status.values}


def raw(office: Office, suffix: str, payload: bytes) -> str:
    """The error reply to a payload that our own programs would not send."""
    replies: list[Any] = []
    for entry in office.bus.network.queryables:
        if str(entry.key) == f"happy/{suffix}":
            entry.call(payload, replies.append, lambda: None)
    (reply,) = replies
    assert reply.is_error
    return str(json.loads(reply.payload)["error"])


def test_two_messages_do_not_end_the_gateway(office: Office) -> None:
    why = raw(office, "lease", b'{"do": "take", "holder": "\\ud800", "seconds": 5.0}')
    assert "lone surrogate" in why
    office.ask("command/drive", linear=0.1, angular=0.0)
    office.run(1.5)
    assert office.ask("lease/state")["holder"] is None
    assert diagnosed(office, "publishers") == {}


@pytest.mark.parametrize(
    ("holder", "why"),
    [
        ("x" * (LONGEST_NAME + 1), "has 201 characters; at most 200 are accepted"),
        ("two\nlines", "holds U+000A, which cannot be printed"),
        ("\u202egnp", "holds U+202E, which cannot be printed"),
        ("", "needs a holder"),
    ],
)
def test_a_holder_is_a_name_in_one_line(office: Office, holder: str, why: str) -> None:
    assert why in hold(office, holder)


def test_a_refusal_that_quotes_what_came_is_short(office: Office) -> None:
    assert len(office.refusal("lease", do="x" * 100_000)) < 1100
    assert len(office.refusal("command/gripper", do="open", **{"y" * 100_000: 1})) < 300
    assert len(office.refusal("command/enable", on="z" * 100_000)) < 300
    office.run(1.5)
    assert max(map(len, office.last("state").faults)) < 1100


@pytest.mark.parametrize("stream", ["odom", "sonar", "bumpers", "battery", "io", "tf_static", "state", "diagnostics"])
def test_an_error_in_one_publisher_costs_this_message_only(
    office: Office, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture, stream: str
) -> None:
    put = memory._MemoryPublisher.put
    errors = iter([UnicodeEncodeError("utf-8", "\ud800", 0, 1, "surrogates not allowed"), ValueError("a bad value")])

    def fail_twice(publisher: memory._MemoryPublisher, message: object, attachment: bytes = b"") -> None:
        if publisher._key == f"happy/{stream}" and (error := next(errors, None)) is not None:
            raise error
        put(publisher, message, attachment)

    office.run(0.2)
    monkeypatch.setattr(memory._MemoryPublisher, "put", fail_twice)
    office.heard.clear()
    with caplog.at_level(logging.ERROR):
        office.run(6.0)
    assert set(office.heard) >= {f"happy/{each}" for each in ("odom", "sonar", "bumpers", "state", "io", stream)}
    assert diagnosed(office, "publishers") == {
        f"error: {stream}: UnicodeEncodeError": "1",
        f"error: {stream}: ValueError": "1",
    }
    assert len([record for record in caplog.records if "was not published" in record.message]) == 2


def test_an_error_in_making_a_message_costs_this_message_only(office: Office, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*args: object) -> None:
        raise OverflowError("too large")

    monkeypatch.setattr("gateway.telemetry.Telemetry.sonar", fail)
    office.run(0.5)
    office.heard.clear()
    office.run(1.0)
    assert "happy/sonar" not in office.heard
    assert {"happy/odom", "happy/bumpers", "happy/state"} <= set(office.heard)


@given(st.sampled_from(REQUESTS), st.data())
@settings(max_examples=300, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_any_value_in_any_field_is_refused_or_obeyed(
    fuzzed: FuzzedRobot, asked: tuple[str, dict[str, Any]], data: st.DataObject
) -> None:
    suffix, arguments = asked
    field = data.draw(st.sampled_from([*arguments, "do", "another"]), "field")
    changed = {**arguments, field: data.draw(ANYTHING, "value")}
    if field != "token" and data.draw(st.booleans(), "without token"):
        changed.pop("token", None)
    fuzzed.give(suffix, json.dumps(changed).encode())
    fuzzed.run(1 / 60)
    assert not fuzzed.outcome.failures


@pytest.mark.parametrize("suffix", sorted({suffix for suffix, _ in REQUESTS} | set(STREAMS)))
def test_any_payload_on_any_key_is_refused_or_obeyed(fuzzed: FuzzedRobot, suffix: str) -> None:
    for payload in (*HOSTILE_PAYLOADS, *STREAMS.values(), b"\0\1\0\0" + b"\xff" * 300):
        fuzzed.give(suffix, payload, b"\xff" * 1000)
    fuzzed.check()


@given(st.sampled_from(sorted(STREAMS)), st.binary(max_size=200), st.binary(max_size=40))
@settings(max_examples=200, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_any_bytes_as_a_velocity_are_obeyed_or_counted(
    fuzzed: FuzzedRobot, suffix: str, payload: bytes, attachment: bytes
) -> None:
    fuzzed.give(suffix, payload, attachment)
    fuzzed.give(suffix, b"\0\1\0\0" + payload, attachment)
    assert not fuzzed.outcome.failures


def test_mutated_payloads_leave_the_gateway_as_it_was() -> None:
    outcome = fuzz_bus.feed(3000, seed=2)
    assert outcome.count == 3000
    assert min(outcome.accepted, outcome.refused, outcome.samples) > 100, "they should reach more than the first check"


def test_every_command_is_fuzzed() -> None:
    suffixes = {suffix for suffix, _ in REQUESTS} | set(STREAMS)
    served = {topic.suffix for topic in keys.TOPICS if topic.kind in (keys.Kind.COMMAND, keys.Kind.QUERY)}
    assert served <= suffixes


def test_the_program_itself_goes_on_whatever_comes_by_zenoh(name: str, bus: Bus) -> None:
    assert isinstance(bus, ZenohBus)
    session = bus._session
    poses: list[str] = []
    bus.subscribe(keys.ODOM.key(name), lambda sample: poses.append(sample.key))
    robot = ("--robot", f"p3dx-sh:{name}", "--world", "empty", "--quiet")
    taken = b'{"do": "take", "holder": "\\ud800", "seconds": 5.0}'
    with emulator(*robot) as robots, gateway(robots.port) as process:
        wait_until(lambda: len(poses) > 3)
        for payload in (*HOSTILE_PAYLOADS, taken, b'{"linear": 0, "angular": 0}'):
            for topic in (keys.LEASE, keys.DRIVE, keys.DESCRIPTION):
                replies = list(session.get(topic.key(name), payload=payload, timeout=patience(LIMIT)))
                assert len(replies) == 1, (topic.suffix, payload[:40])
            for topic in (keys.CMD_VEL, keys.CMD_VEL_STAMPED):
                session.put(topic.key(name), payload, attachment=b"\xff\xfe" * 1000)
        so_far = len(poses)
        wait_until(lambda: len(poses) > so_far + 20)
        assert bus.query(keys.LEASE_STATE.key(name))[0].value["holder"] is None
        assert process.poll() is None

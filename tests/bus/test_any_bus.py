"""What every bus does, whichever kind it is."""

import logging
from collections.abc import Callable
from typing import Any

import pytest

from bus import Bus, BusUnavailable, KeyNotValid, MessageError, NoAnswer, Refused, Sample
from bus.bus import JSON
from bus.messages import decode, twist

TWIST = "geometry_msgs/msg/Twist"
Until = Callable[..., None]


@pytest.fixture
def here(meeting: Any) -> Bus:
    bus: Bus = meeting.join()
    return bus


@pytest.fixture
def there(meeting: Any) -> Bus:
    bus: Bus = meeting.join()
    return bus


def test_a_message_arrives_with_key_type_and_attachment(
    meeting: Any, here: Bus, there: Bus, robot: str, until: Until
) -> None:
    heard: list[Sample] = []
    there.subscribe(f"{robot}/cmd_vel", heard.append)
    meeting.settle()
    here.publisher(f"{robot}/cmd_vel", TWIST).put(twist(0.2, -0.1), b"token")
    until(lambda: heard)
    assert (heard[0].key, heard[0].type_name, heard[0].attachment) == (f"{robot}/cmd_vel", TWIST, b"token")
    assert heard[0].encoding == f"application/cdr;{TWIST}"
    assert decode(TWIST, heard[0].payload) == twist(0.2, -0.1)


def test_messages_arrive_in_the_order_of_their_puts(
    meeting: Any, here: Bus, there: Bus, robot: str, until: Until
) -> None:
    heard: list[float] = []
    there.subscribe(f"{robot}/cmd_vel", lambda sample: heard.append(decode(TWIST, sample.payload).linear.x))
    meeting.settle()
    for number in range(100):
        here.send(f"{robot}/cmd_vel", twist(number, 0.0))
    until(lambda: len(heard) == 100)
    assert heard == list(range(100))


def test_bytes_of_others_are_passed_on_unchanged(meeting: Any, here: Bus, there: Bus, robot: str, until: Until) -> None:
    heard: list[Sample] = []
    there.subscribe(f"{robot}/strange", heard.append)
    meeting.settle()
    foreign = Sample(f"{robot}/strange", b"\x00\xff??", "application/protobuf", b"token")
    here.deliver(foreign)
    until(lambda: heard)
    assert heard == [foreign]
    with pytest.raises(KeyNotValid):
        here.deliver(Sample(f"{robot}/*", b""))


def test_a_participant_hears_itself(here: Bus, robot: str, until: Until) -> None:
    heard: list[Sample] = []
    here.subscribe(f"{robot}/cmd_vel", heard.append)
    here.put(f"{robot}/cmd_vel", twist(0.1, 0.0))
    until(lambda: heard)


def test_wildcards_match_chunks(meeting: Any, here: Bus, there: Bus, robot: str, until: Until) -> None:
    one, many = [], []
    there.subscribe(f"{robot}/*", lambda sample: one.append(sample.key))
    there.subscribe(f"{robot}/**", lambda sample: many.append(sample.key))
    meeting.settle()
    for suffix in ("sonar", "sonar/points", "end"):
        here.send(f"{robot}/{suffix}", {})
    until(lambda: len(many) == 3 and len(one) == 2)
    assert one == [f"{robot}/sonar", f"{robot}/end"]
    assert many == [f"{robot}/sonar", f"{robot}/sonar/points", f"{robot}/end"]


def test_a_dict_travels_as_json(meeting: Any, here: Bus, there: Bus, robot: str, until: Until) -> None:
    heard: list[Sample] = []
    there.subscribe(f"{robot}/lease/state", heard.append)
    meeting.settle()
    here.put(f"{robot}/lease/state", {"holder": None})
    here.publisher(f"{robot}/lease/state", JSON).put({"holder": "me"})
    until(lambda: len(heard) == 2)
    assert [sample.payload for sample in heard] == [b'{"holder":null}', b'{"holder":"me"}']
    assert heard[0].encoding == heard[1].encoding == JSON
    assert heard[0].type_name == ""


def test_a_publisher_refuses_what_is_not_of_its_type(here: Bus, robot: str) -> None:
    publisher = here.publisher(f"{robot}/odom", "nav_msgs/msg/Odometry")
    with pytest.raises(MessageError, match=r"carries nav_msgs/msg/Odometry, not geometry_msgs/msg/Twist"):
        publisher.put(twist(0.0, 0.0))
    with pytest.raises(MessageError, match="dict is not a message"):
        publisher.put({})
    with pytest.raises(MessageError, match="unknown message type"):
        here.publisher(f"{robot}/odom", "nav_msgs/msg/Odometri")


def test_a_publisher_knows_whether_somebody_listens(
    meeting: Any, here: Bus, there: Bus, robot: str, until: Until
) -> None:
    publisher = here.publisher(f"{robot}/containers/{robot}/said", JSON)
    listening_elsewhere = there.subscribe(f"{robot}/containers/other/said", lambda sample: None)
    meeting.settle()
    assert not publisher.has_listeners
    listening = there.subscribe("*/containers/*/said", lambda sample: None)
    until(lambda: publisher.has_listeners, "the publisher has heard of the listener")
    listening.close()
    until(lambda: not publisher.has_listeners, "the publisher has heard that the listener has gone")
    listening_elsewhere.close()


def test_a_publisher_is_told_of_its_first_listener_and_when_the_last_one_has_gone(
    meeting: Any, here: Bus, there: Bus, robot: str, until: Until
) -> None:
    publisher = here.publisher(f"{robot}/said", JSON)
    told: list[bool] = []
    publisher.watch_listeners(told.append)
    meeting.settle()
    first = there.subscribe("*/said", lambda sample: None)
    second = there.subscribe(f"{robot}/*", lambda sample: None)
    until(lambda: told == [True], "the publisher is told of the listener")
    third = here.subscribe(f"{robot}/said", lambda sample: None)
    first.close()
    second.close()
    meeting.settle()
    assert told == [True]
    third.close()
    until(lambda: told == [True, False], "the publisher is told that the last listener has gone")
    publisher.close()
    there.subscribe(f"{robot}/*", lambda sample: None)
    meeting.settle()
    assert told == [True, False]


def test_a_publisher_is_told_of_a_listener_that_is_there_already(
    meeting: Any, here: Bus, there: Bus, robot: str, until: Until
) -> None:
    there.subscribe(f"{robot}/said", lambda sample: None)
    meeting.settle()
    told: list[bool] = []
    here.publisher(f"{robot}/said", JSON).watch_listeners(told.append)
    until(lambda: told == [True], "the publisher is told of the listener")


def test_a_closed_publisher_has_no_listeners(here: Bus, robot: str) -> None:
    here.subscribe(f"{robot}/said", lambda sample: None)
    one, other = here.publisher(f"{robot}/said", JSON), here.publisher(f"{robot}/said", JSON)
    assert [each.has_listeners for each in (one, other)] == [True, True]
    one.close()
    assert [each.has_listeners for each in (one, other)] == [False, True]
    here.close()
    assert [each.has_listeners for each in (one, other)] == [False, False]


def test_a_query_is_answered_with_its_arguments(meeting: Any, here: Bus, there: Bus, robot: str) -> None:
    there.serve(f"{robot}/command/move", lambda arguments: {"accepted": True, "got": arguments})
    meeting.settle()
    (answer,) = here.query(f"{robot}/command/move", {"distance": 1.5})
    assert (answer.key, answer.value) == (f"{robot}/command/move", {"accepted": True, "got": {"distance": 1.5}})
    assert here.query(f"{robot}/command/move")[0].value["got"] == {}


def test_every_answerer_of_a_query_is_heard(meeting: Any, here: Bus, there: Bus, robot: str) -> None:
    here.serve(f"{robot}/description", lambda arguments: {"bus": "here"})
    there.serve(f"{robot}/description", lambda arguments: {"bus": "there"})
    there.serve(f"{robot}/lease", lambda arguments: {"lease": True})
    meeting.settle()
    assert sorted(answer.value["bus"] for answer in here.query(f"{robot}/description")) == ["here", "there"]
    assert len(here.query(f"{robot}/*")) == 3


def test_a_refusal_comes_back_with_its_reason(meeting: Any, here: Bus, there: Bus, robot: str) -> None:
    def refuse(arguments: dict[str, Any]) -> dict[str, Any]:
        raise Refused("someone else holds the lease")

    there.serve(f"{robot}/command/stop", refuse)
    there.serve(f"{robot}/command/enable", lambda arguments: {"accepted": True})
    meeting.settle()
    with pytest.raises(Refused, match=r"^someone else holds the lease$"):
        here.query(f"{robot}/command/stop")
    with pytest.raises(Refused) as caught:
        here.query(f"{robot}/command/*")
    assert caught.value.answers == {f"{robot}/command/enable": {"accepted": True}}


def test_a_failing_handler_is_logged_and_goes_on_serving(
    meeting: Any, here: Bus, there: Bus, robot: str, caplog: pytest.LogCaptureFixture
) -> None:
    there.serve(f"{robot}/command/move", lambda arguments: {"half": arguments["distance"] / 2})
    meeting.settle()
    with caplog.at_level(logging.ERROR, "bus"), pytest.raises(Refused, match=r"move failed with KeyError: 'distance'$"):
        here.query(f"{robot}/command/move")
    assert "Traceback" in caplog.text
    assert here.query(f"{robot}/command/move", {"distance": 3})[0].value == {"half": 1.5}


def test_an_answer_without_json_form_is_an_error_reply(meeting: Any, here: Bus, there: Bus, robot: str) -> None:
    there.serve(f"{robot}/description", lambda arguments: {"range": float("inf")})
    meeting.settle()
    with pytest.raises(Refused, match="cannot be written as JSON"):
        here.query(f"{robot}/description")


def test_no_answerer_is_a_failure(meeting: Any, here: Bus, there: Bus, robot: str) -> None:
    serving = there.serve(f"{robot}/description", lambda arguments: {})
    meeting.settle()
    assert here.query(f"{robot}/description")
    serving.close()
    meeting.settle()
    with pytest.raises(NoAnswer, match=f"nobody answered on {robot}/description"):
        here.query(f"{robot}/description")


def test_a_closed_subscription_hears_nothing_more(
    meeting: Any, here: Bus, there: Bus, robot: str, until: Until
) -> None:
    closed: list[Sample] = []
    heard: list[Sample] = []
    with there.subscribe(f"{robot}/x", closed.append):
        there.subscribe(f"{robot}/x", heard.append)
        meeting.settle()
        here.send(f"{robot}/x", {})
        until(lambda: heard and closed)
    here.send(f"{robot}/x", {})
    until(lambda: len(heard) == 2)
    assert len(closed) == 1


def test_a_handler_that_raises_is_logged_and_hears_the_next(
    meeting: Any, here: Bus, there: Bus, robot: str, until: Until, caplog: pytest.LogCaptureFixture
) -> None:
    heard: list[bytes] = []

    def hear(sample: Sample) -> None:
        heard.append(sample.payload)
        raise ValueError("this sample is bad")

    there.subscribe(f"{robot}/x", hear)
    meeting.settle()
    for number in range(2):
        here.send(f"{robot}/x", {"n": number})
    until(lambda: len(heard) == 2)
    until(lambda: caplog.text.count("ValueError: this sample is bad") == 2)
    assert f"the handler of {robot}/x failed" in caplog.text


def test_a_token_is_seen_while_its_owner_lives(meeting: Any, here: Bus, there: Bus, robot: str, until: Until) -> None:
    changes: list[tuple[str, bool]] = []
    early = there.declare_alive(f"{robot}/alive")
    meeting.settle()
    here.watch_alive(f"{robot}/*", lambda key, is_alive: changes.append((key, is_alive)))
    until(lambda: changes == [(f"{robot}/alive", True)], "a late watcher has seen the token")
    early.close()
    until(lambda: changes[1:] == [(f"{robot}/alive", False)])
    there.declare_alive(f"{robot}/alive")
    until(lambda: changes[2:] == [(f"{robot}/alive", True)])
    there.close()
    until(lambda: changes[3:] == [(f"{robot}/alive", False)], "the token has gone with its owner")


def test_a_token_shown_by_two_goes_with_the_last(meeting: Any, here: Bus, there: Bus, robot: str, until: Until) -> None:
    changes: list[tuple[str, bool]] = []
    watcher = meeting.join()
    watcher.watch_alive(f"{robot}/*", lambda key, is_alive: changes.append((key, is_alive)))
    first = here.declare_alive(f"{robot}/alive")
    second = there.declare_alive(f"{robot}/alive")
    meeting.settle()
    first.close()
    marker = here.declare_alive(f"{robot}/marker")
    until(lambda: (f"{robot}/marker", True) in changes)
    marker.close()
    second.close()
    until(lambda: (f"{robot}/alive", False) in changes)
    assert [is_alive for key, is_alive in changes if key == f"{robot}/alive"] == [True, False]
    assert changes.index((f"{robot}/marker", True)) < changes.index((f"{robot}/alive", False))


@pytest.mark.parametrize("key", ["", "/odom", "a//b", "a/", "a?b", "a#b"])
def test_a_malformed_key_is_refused_in_one_sentence(here: Bus, key: str) -> None:
    uses: list[Callable[[], object]] = [
        lambda: here.subscribe(key, lambda sample: None),
        lambda: here.watch_alive(key, lambda token, is_alive: None),
        lambda: here.serve(key, lambda arguments: {}),
        lambda: here.put(key, {}),
        lambda: here.send(key, {}),
        lambda: here.query(key),
    ]
    for use in uses:
        with pytest.raises(KeyNotValid, match=r"^'.*' is not a key: ") as caught:
            use()
        assert ".rs" not in str(caught.value), "a place in Zenoh's source helps nobody"


def test_wildcards_are_refused_where_one_key_is_needed(here: Bus, robot: str) -> None:
    for use in (
        lambda key: here.publisher(key, TWIST),
        lambda key: here.put(key, {}),
        lambda key: here.serve(key, lambda arguments: {}),
        here.declare_alive,
    ):
        with pytest.raises(KeyNotValid, match="stands for several keys"):
            use(f"{robot}/*")


def test_a_closed_bus_refuses_everything(here: Bus, robot: str) -> None:
    publisher = here.publisher(f"{robot}/x", JSON)
    subscription = here.subscribe(f"{robot}/x", lambda sample: None)
    here.close()
    here.close()
    subscription.close()
    publisher.close()
    for use in (
        lambda: publisher.put({}),
        lambda: here.publisher(f"{robot}/x", JSON),
        lambda: here.put(f"{robot}/x", {}),
        lambda: here.send(f"{robot}/x", {}),
        lambda: here.subscribe(f"{robot}/x", lambda sample: None),
        lambda: here.serve(f"{robot}/x", lambda arguments: {}),
        lambda: here.query(f"{robot}/x"),
        lambda: here.declare_alive(f"{robot}/x"),
        lambda: here.watch_alive(f"{robot}/x", lambda key, is_alive: None),
    ):
        with pytest.raises(BusUnavailable):
            use()


def test_a_handler_may_put_and_query(meeting: Any, here: Bus, there: Bus, robot: str, until: Until) -> None:
    heard: list[str] = []

    def relay(sample: Sample) -> None:
        answer = there.query(f"{robot}/question")[0]
        there.send(f"{robot}/second", answer.value)

    here.serve(f"{robot}/question", lambda arguments: {"answer": 42})
    there.subscribe(f"{robot}/first", relay)
    here.subscribe(f"{robot}/second", lambda sample: heard.append(sample.payload.decode()))
    meeting.settle()
    here.send(f"{robot}/first", {})
    until(lambda: heard == ['{"answer":42}'])

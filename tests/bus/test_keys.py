import pytest
from hypothesis import given
from hypothesis import strategies as st

from bus import KeyNotValid, keys
from bus.bus import JSON
from bus.exchange import plain_key
from bus.keys import TOPICS, Kind, Topic, robot_name, topic_of
from bus.messages import prepare


@pytest.mark.parametrize("topic", TOPICS, ids=lambda topic: topic.suffix)
def test_every_row_of_the_table_names_a_type_that_exists(topic: Topic) -> None:
    if topic.kind is Kind.TOKEN:
        assert topic.type_name == ""
    elif topic.type_name != JSON:
        prepare(topic.type_name)
    assert topic.meaning


def test_every_suffix_is_in_the_table_once() -> None:
    suffixes = [topic.suffix for topic in TOPICS]
    assert len(suffixes) == len(set(suffixes))
    listed = {id(topic) for topic in TOPICS}
    assert all(id(value) in listed for value in vars(keys).values() if isinstance(value, Topic))


@pytest.mark.parametrize("topic", TOPICS, ids=lambda topic: topic.suffix)
def test_a_key_leads_back_to_its_row(topic: Topic) -> None:
    assert topic_of(topic.key("happy").replace("*", "17")) is topic


def test_a_strange_key_belongs_to_no_row() -> None:
    assert topic_of("happy/odometry") is None
    assert topic_of("happy") is None
    assert topic_of("happy/command/unheard_of") is None


def test_results_have_a_key_each() -> None:
    assert keys.RESULT.key("happy", "17") == "happy/command/result/17"
    assert topic_of(keys.RESULT.key("happy", "17")) is keys.RESULT


def test_tokens_of_elements_have_a_key_each() -> None:
    assert keys.ELEMENT_ALIVE.key("happy", "laser") == "happy/elements/laser/alive"
    assert topic_of(keys.ELEMENT_ALIVE.key("happy", "laser")) is keys.ELEMENT_ALIVE
    assert topic_of("happy/elements/laser") is None


def test_frames_are_spelled_with_the_robots_name() -> None:
    assert keys.frame("happy", "base_link") == "happy/base_link"


@pytest.mark.parametrize("name", ["", "a/b", "a*", "a b", "a$", "a?", "a#", "@a", "a\n", "a\t", "a\u00a0b", "\x00"])
def test_what_cannot_name_a_robot_is_refused_in_one_sentence(name: str) -> None:
    with pytest.raises(KeyNotValid, match="cannot name a robot because it") as caught:
        robot_name(name)
    assert "\n" not in str(caught.value)
    with pytest.raises(KeyNotValid):
        keys.ODOM.key(name)


@given(st.text(max_size=8))
def test_whatever_names_a_robot_makes_a_sound_key(name: str) -> None:
    try:
        robot_name(name)
    except KeyNotValid:  # it names no robot
        return
    assert plain_key(keys.ODOM.key(name)) == f"{name}/odom"

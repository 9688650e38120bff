"""Names of agents are two chunks of a key."""

import pytest

from agents.platform import AgentError, AgentName, NameNotValid


def test_a_name_is_written_as_it_is_read() -> None:
    name = AgentName.parse("base@happy")
    assert (name.local, name.platform, str(name)) == ("base", "happy", "base@happy")


def test_each_key_leads_back_to_its_agent() -> None:
    name = AgentName("base", "happy")
    assert name.acl_key == "happy/agents/base/acl"
    for key in (name.acl_key, name.alive_key, name.description_key, name.results_key):
        assert AgentName.of_key(key) == name


@pytest.mark.parametrize("key", ["happy/odom", "happy/alive", "happy/agents/base/other", "happy/agents/a@b/alive"])
def test_a_key_of_something_else_names_no_agent(key: str) -> None:
    with pytest.raises(NameNotValid):
        AgentName.of_key(key)


@pytest.mark.parametrize("text", ["", "base", "@happy", "base@", "a@b@c", "a/b@c", "a*@c", "a b@c", "a@b\n", "a#@b"])
def test_what_is_no_name_is_refused_in_one_sentence(text: str) -> None:
    with pytest.raises(NameNotValid) as caught:
        AgentName.parse(text)
    assert isinstance(caught.value, AgentError)
    assert "robot" not in str(caught.value)

"""The broker is started by its kind, as its page shows; tests/agents/platform/test_more_protocols.py has it at work."""

import re

from agents.platform import AgentName, Kinds
from agents.services.broker import BrokerAgent
from tests.shown import page


def test_a_container_finds_the_kind_that_the_page_names() -> None:
    (kind,) = re.findall(r"agents\.services\.broker:\w+", page("protocols"))
    assert isinstance(Kinds().make(kind, AgentName("broker", "team"), {}), BrokerAgent)

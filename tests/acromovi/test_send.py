"""`acromovi send` sends any ACL message to agents on the real bus, and prints the replies."""

import json
from collections.abc import Iterator
from typing import Any

import pytest

from acromovi.__main__ import main
from agents.platform import Agent, AgentName, Performative, every, proposes, request
from bus import Refused
from tests.acromovi.agents_alive import living


class Parrot(Agent):
    """Does, refuses and bids; answers each message in its mailbox with the same content."""

    @request("say")
    async def say(self, word: str) -> dict[str, Any]:
        return {"said": word}

    @request("sing")
    async def sing(self) -> None:
        raise Refused("I never sing \x1b[31m")

    @proposes("say")
    async def bid(self, word: str) -> dict[str, Any]:
        return {"price": len(word)}

    @every(0.01)
    async def echo(self) -> None:
        message = await self.receive()
        self.send(message.reply(Performative.INFORM, message.content))


@pytest.fixture(scope="module")
def parrot() -> Iterator[str]:
    from tests.acromovi.team.private_bus import private_bus

    profile = private_bus()
    with living("birds", Parrot(AgentName("parrot", "birds")), profile=profile):
        yield profile


def send(profile: str, *words: str) -> int:
    try:
        return main(["send", *words, "--bus", profile])
    except SystemExit as err:
        return int(str(err.code))


def test_a_request_prints_each_reply(parrot: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert send(parrot, "request", "parrot@birds", "--action", "say", "word=hello") == 0
    assert capsys.readouterr().out.splitlines() == [
        "parrot@birds  agree",
        'parrot@birds  inform  {"said": "hello"}',
    ]


def test_a_refusal_is_printed_as_text_and_is_a_failure(parrot: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert send(parrot, "request", "parrot@birds", "--action", "sing") == 1
    shown = capsys.readouterr().out
    assert shown.startswith("parrot@birds  refuse  I never sing ")
    assert "\x1b" not in shown


def test_a_call_for_proposals_prints_the_proposal(parrot: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert send(parrot, "cfp", "parrot@birds", "--action", "say", "word=hi", "--wait", "0.5", "--json") == 0
    reply = json.loads(capsys.readouterr().out)
    assert (reply["performative"], reply["content"], reply["protocol"]) == (
        "propose",
        {"price": 2},
        "fipa-contract-net",
    )


def test_a_message_to_the_mailbox_is_answered_there(parrot: str, capsys: pytest.CaptureFixture[str]) -> None:
    words = [
        "inform",
        "parrot@birds",
        "--content",
        '{"x": [1, 2]}',
        "--protocol",
        "my-talk",
        "--conversation",
        "talk-1",
    ]
    assert send(parrot, *words, "--reply-with", "a-1", "--reply-by", "3", "--wait", "3", "--json") == 0
    reply = json.loads(capsys.readouterr().out)
    assert (reply["content"], reply["protocol"], reply["conversation_id"]) == ({"x": [1, 2]}, "my-talk", "talk-1")
    assert reply["in_reply_to"] == "a-1"


def test_without_waiting_it_ends_at_once(parrot: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert send(parrot, "confirm", "parrot@birds", "--content", '"yes"') == 0
    assert capsys.readouterr().out == ""


@pytest.mark.parametrize(
    ("words", "code", "says"),
    [
        (["requst", "parrot@birds"], 2, "there is no performative 'requst' (did you mean request?)"),
        (["request", "parrot@birds", "--action", "say", "word"], 2, "--action say: 'word' is not KEY=VALUE"),
        (["inform", "parrot@birds", "--content", "{"], 2, "'{' is not JSON"),
        (["inform", "parrot@birds", "--content", "1", "--action", "say"], 2, "give --action or --content, not both"),
        (["inform", "parot@birds"], 1, "parot@birds"),
        (["request", "parrot@birds", "--content", "3"], 1, ""),
    ],
)
def test_mistakes_are_answered_in_a_sentence(
    words: list[str], code: int, says: str, parrot: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert send(parrot, *words) == code
    assert says in capsys.readouterr().err

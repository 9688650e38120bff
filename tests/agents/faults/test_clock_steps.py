"""The wall clock is set an hour forward or back while agents talk: nothing depends on it but what is written down.

All patience is measured on the steady clock of the event loop. `reply_by` is wall time, as FIPA wants it, and so it is
for people and records: clocks of machines differ and step, and no answer is held back because of it.
"""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from agents.platform import AclMessage, Ending, Performative
from bus import MemoryBus
from tests.agents.faults.pair import INITIATOR, RESPONDER, Pair
from tests.agents.faults.scripts import SCRIPTS, Script

HOUR = 3600.0  # s
ROOT = Path(__file__).resolve().parents[3]
WALL_CLOCKS = {"time.time", "time.time_ns", "datetime.now", "datetime.datetime.now", "datetime.utcnow", "date.today"}
IN_QUESTION = re.compile(r"time\.time|from time|datetime|today")  # to read the others would take long
READ_IT = {
    "agents/platform/container/container.py": "the time in reports, records and reply_by",
    "bus/name_holder.py": "which of two programs that took one name together leaves",
    "bus/secure.py": "whether a certificate is valid",
    "cameras/reader.py": "stamps of pictures",
    "gateway/bridge.py": "stamps of messages",
    "gateway/robot_on_bus.py": "stamps of messages",
}


@pytest.mark.parametrize("step", [HOUR, -HOUR])
@pytest.mark.parametrize("script", SCRIPTS, ids=lambda script: script.name)
def test_a_step_changes_neither_the_end_of_a_conversation_nor_when_it_comes(
    pair: Pair, script: Script, step: float
) -> None:
    def timed() -> tuple[Ending, float]:
        begun = pair.loop.time()
        ending = pair.run(script.begin(pair.initiator.agent, pair.responder.agent.name))
        return ending, round(pair.loop.time() - begun, 6)

    undisturbed = timed()
    assert undisturbed[0] is script.ending
    pair.loop.call_later(0.5, setattr, pair, "ahead", step)
    assert timed() == undisturbed


@pytest.mark.parametrize("step", [HOUR, -HOUR])
def test_patience_and_tickers_do_not_feel_a_step(pair: Pair, step: float) -> None:
    beats: list[float] = []

    async def beat() -> None:
        beats.append(pair.loop.time())

    async def begin() -> None:
        pair.responder.agent.every(1.0, beat)

    pair.run(begin())
    begun = pair.loop.time()
    pair.loop.call_later(2.0, setattr, pair, "ahead", step)
    outcome = pair.run(pair.initiator.agent.request(RESPONDER, "work", reply_within=5.0))
    assert outcome.ending is Ending.TIMED_OUT
    assert pair.loop.time() - begun == pytest.approx(5.0)
    pair.loop.run_for(0.5)
    assert [beat - begun for beat in beats] == pytest.approx([1.0, 2.0, 3.0, 4.0, 5.0])


@pytest.mark.parametrize("ahead", [HOUR, -HOUR])
def test_a_request_from_a_machine_with_another_time_is_done(pair: Pair, ahead: float) -> None:
    opening = AclMessage(
        performative=Performative.REQUEST,
        sender=INITIATOR,
        content={"action": "look"},
        reply_by=pair.wall_time() + ahead,
    )
    replies: list[str] = []
    MemoryBus(pair.network).ask(
        RESPONDER.acl_key,
        opening.to_dict(),
        lambda answer: replies.append(answer.value["performative"]),
        lambda error: None,
    )
    pair.loop.run_for(1.0)
    assert replies == ["agree", "inform"]


def test_what_is_written_down_bears_the_time_that_the_clock_shows(pair: Pair) -> None:
    said: list[AclMessage] = []
    pair.initiator.container.tap = said.append
    for ahead in (0.0, HOUR, -HOUR):
        pair.ahead = ahead
        begun = pair.wall_time()
        assert pair.run(pair.initiator.agent.request(RESPONDER, "look", reply_within=5.0)).is_done
        assert said.pop().reply_by == pytest.approx(begun + 5.0)


@pytest.mark.parametrize("room", ["agents", "bus", "cameras", "gateway", "p2os"])
def test_the_wall_clock_is_read_for_what_is_written_down_only(room: str) -> None:
    reads = {str(path.relative_to(ROOT)) for path in (ROOT / room).rglob("*.py") if set(wall_clocks(path))}
    assert reads == {path for path in READ_IT if path.startswith(f"{room}/")}


def wall_clocks(path: Path) -> Iterator[str]:
    """The wall clocks that a module names."""
    text = path.read_text(encoding="utf-8")
    for node in ast.walk(ast.parse(text)) if IN_QUESTION.search(text) else ():
        if isinstance(node, ast.Attribute) and (name := ast.unparse(node)) in WALL_CLOCKS:
            yield name
        elif isinstance(node, ast.ImportFrom) and node.module == "time":
            yield from (alias.name for alias in node.names if f"time.{alias.name}" in WALL_CLOCKS)

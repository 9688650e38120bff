"""The host side of recorded conversations, replayed: ARIA programs, the ROS 1 driver and CARMEN.

The recordings lie beside the repository, not in it. Pauses are shortened, but each SYNC waits for its answer.
"""

import json
import time
from pathlib import Path

import pytest

from pty_tests.client import Client, Splitter
from pty_tests.conftest import Site
from pty_tests.packets import CONFIGPAC, Sip

CAPTURES = Path(__file__).resolve().parents[2] / "shared" / "captures"
REPLAYED_IN = 2.5  # s; the longest took half a minute
SLOWLY = {"aria-gotoAction": 10.0}  # s; it commands less than 20 mm/s, for 4 s of its 34 s
LONGEST_PAUSE = 0.25  # s, as replayed
SPEEDS = {"aria-gotoAction": 5, "aria-wander": 50, "carmen": 50, "ros-p2os": 50}  # mm/s that a wheel must have reached


def host_side(path: Path) -> list[tuple[float, bytes]]:
    """When (s) the client wrote what."""
    lines = [json.loads(line) for line in path.read_text().splitlines()]
    return [(line["t"], bytes.fromhex(line["hex"])) for line in lines if line["from"] == "host"]


def replay(robot: Client, writes: list[tuple[float, bytes]], seconds: float) -> list[bytes]:
    """Write all that the client wrote, in s; return the payloads that came back after the handshake."""
    heard: list[bytes] = []
    syncs = [0, 1, 2]
    due, before, end = time.monotonic(), writes[0][0], writes[-1][0]
    faster = (end - before) / seconds
    for at, raw in writes:
        due += min((at - before) / faster, LONGEST_PAUSE)
        before = at
        heard += [item.payload for item in robot.hear(due - time.monotonic(), pulse=False)]
        robot.write(raw)
        if syncs and list(Splitter().receive(raw)) == [bytes([syncs[0]])]:
            robot.next(syncs.pop(0), pulse=False)
    return heard


pytestmark = pytest.mark.skipif(not CAPTURES.is_dir(), reason="the recordings are not beside the repository")


@pytest.mark.parametrize("program", SPEEDS)
@pytest.mark.emulate("p3dx-sh")
def test_a_recorded_client_is_served(site: Site, line: Client, program: str) -> None:
    assert_served(site, line, program)


@pytest.mark.emulate("powerbot-sh")
def test_a_recorded_client_of_the_powerbot_is_served(site: Site, line: Client) -> None:
    assert_served(site, line, "aria-wander")


def assert_served(site: Site, line: Client, program: str) -> None:
    """The conversation goes as the recorded one did: CONFIGpac if asked for, a steady stream, wheels that turn."""
    if not site.emulated:
        pytest.skip("a recorded program drives further than a tester's floor")
    path = CAPTURES / f"{program}.{site.model}.jsonl"
    if not path.is_file():
        pytest.skip(f"no recording {path.name}")
    began = time.monotonic()
    heard = replay(line, host_side(path), SLOWLY.get(program, REPLAYED_IN))
    sips = [Sip.parse(payload) for payload in heard if Sip.is_one(payload)]
    assert len(sips) >= (time.monotonic() - began) * 10 * 0.5, "the stream faltered"
    if program.startswith("aria"):
        assert CONFIGPAC in {payload[0] for payload in heard}, "ARIA asked for it"
    assert any(sip.motors for sip in sips)
    fastest = max(abs(sip.left) for sip in sips)
    assert fastest > SPEEDS[program], "the drive commands moved no wheel"
    list(line.hear(0.5, pulse=False))  # what was on its way
    assert not list(line.hear(0.25, pulse=False)), "the stream went on after the client's CLOSE"

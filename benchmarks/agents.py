"""What talk between agents costs: requests, floods of informs, crowds, and looking somebody up."""

import argparse
import asyncio
import json
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from agents.platform import AclMessage, Agent, AgentName, Container, Directory, Performative
from benchmarks.agent_peer import command_of
from benchmarks.figures import Figure, p50_p99, percentile
from benchmarks.processes import CpuMeter, resident_megabytes
from bus import ZenohBus

REQUESTS = 2000
WARM_UP = 100
PAIRS, INFORMS_PER_S, SECONDS = 4, 10_000, 60
BURST_S = 0.004
CROWD, IDLE_S, SETTLE_S = 1000, 20.0, 3.0
PROCESSES, SESSIONS_EACH, AGENTS_EACH, SEARCHES = 4, 25, 4, 20
ROUTER_ADDRESS = "tcp/127.0.0.1:17447"
MEETING_TIME_S = 30.0


def measure(options: argparse.Namespace) -> list[Figure]:
    """Each with containers in other processes."""
    return [*asyncio.run(_requests()), *asyncio.run(_informs()), *_crowd(), *_search()]


@contextmanager
def peer(kind: str, *arguments: str) -> Iterator[int]:
    """Run the other side; gives its process's number once it serves."""
    with subprocess.Popen(
        command_of(kind, *arguments), stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        if not process.stdout.readline():
            raise RuntimeError(f"the peer {kind} did not come up")
        yield process.pid


async def _requests() -> list[Figure]:
    """Request, agree and inform between two containers, ms."""
    times = []
    with peer("echo", "bench-echo"), ZenohBus.open() as bus:
        async with Container(bus, "bench-asker", platform="bench") as container:
            asker = Agent(AgentName("asker", "bench"))
            await container.start(asker)
            await _until_known(bus, 1, "bench-echo")
            for number in range(REQUESTS + WARM_UP):
                began = time.perf_counter()
                outcome = await asker.request("echo@bench-echo", "echo", number=number)
                times.append((time.perf_counter() - began) * 1e3)
                if outcome.value() != number:
                    raise RuntimeError("the echo answered something else")
    return p50_p99("agents", "ACL request, agree, inform between containers", times[WARM_UP:], (1.0, 5.0), "ms")


async def _informs() -> list[Figure]:
    """A minute of one-way messages at an even pace: what is lost, doubled or out of order."""
    with peer("counters", "bench-counters", str(PAIRS)), ZenohBus.open() as bus:
        async with Container(bus, "bench-senders", platform="bench") as container:
            senders = [Agent(AgentName(f"sender{index}", "bench")) for index in range(PAIRS)]
            for sender in senders:
                await container.start(sender)
            await _until_known(bus, PAIRS, "bench-counters")
            sent = await asyncio.to_thread(_send_evenly, senders)
            counted = [await _all_counted(senders[0], f"counter{index}@bench-counters", sent) for index in range(PAIRS)]
    lost = sum(sent - 1 - max(each["last"].values(), default=-1) for each in counted)
    wrong = sum(each["out_of_order"] + each["dropped"] for each in counted)
    return [
        Figure("agents", f"informs lost of {sent * PAIRS}, {INFORMS_PER_S} a second", lost, 0.0, "", sent * PAIRS),
        Figure("agents", "informs doubled, dropped or out of order", wrong, 0.0, "", sent * PAIRS),
    ]


def _send_evenly(senders: list[Agent]) -> int:
    """Send in small bursts; returns how many each has sent."""
    per_burst = int(INFORMS_PER_S / len(senders) * BURST_S)
    receivers = [AgentName(f"counter{index}", "bench-counters") for index in range(len(senders))]
    began, sent = time.monotonic(), 0
    for burst in range(int(SECONDS / BURST_S)):
        time.sleep(max(0.0, began + burst * BURST_S - time.monotonic()))
        for number in range(sent, sent + per_burst):
            for sender, receiver in zip(senders, receivers, strict=True):
                sender.send(
                    AclMessage(
                        performative=Performative.INFORM, sender=sender.name, receivers=(receiver,), content=number
                    )
                )
        sent += per_burst
    return sent


async def _all_counted(asker: Agent, counter: str, sent: int) -> dict[str, Any]:
    """What a counter has counted, once it has counted all or nothing more comes."""
    before = None
    while True:
        counted: dict[str, Any] = (await asker.request(counter, "counted")).value()
        if counted == before or max(counted["last"].values(), default=-1) == sent - 1:
            return counted
        before = counted
        await asyncio.sleep(0.5)


def _crowd() -> list[Figure]:
    """A thousand agents that do nothing."""
    with peer("crowd", "bench-crowd", str(CROWD)) as pid:
        time.sleep(SETTLE_S)
        meter = CpuMeter(pid)
        time.sleep(IDLE_S)
        share, memory = meter.percent(), resident_megabytes(pid)
    return [
        Figure("agents", f"processor, {CROWD} agents in one container, idle", share, 5.0, "%"),
        Figure("agents", f"memory, {CROWD} agents in one container", memory, 250.0, "MB"),
    ]


def _search() -> list[Figure]:
    """A search of the directory over many sessions that meet at one router, ms."""
    with TemporaryDirectory() as folder, ExitStack() as stack:
        profile = Path(folder) / "bench-router.toml"
        profile.write_text(_PROFILE)
        stack.enter_context(_router())
        for index in range(PROCESSES):
            stack.enter_context(
                peer("sessions", str(profile), f"bench-site{index}", str(SESSIONS_EACH), str(AGENTS_EACH))
            )
        times = asyncio.run(_searches(str(profile)))
    name = f"directory search over {PROCESSES * SESSIONS_EACH} sessions through one router, worst"
    return [Figure("agents", name, percentile(times, 100), 100.0, "ms", len(times))]


async def _searches(profile: str) -> list[float]:
    wanted = PROCESSES * SESSIONS_EACH * AGENTS_EACH
    times = []
    with ZenohBus.open(profile) as bus:
        await _until_known(bus, wanted, "bench-site")
        with Directory(bus) as directory:
            for _ in range(SEARCHES):
                began = time.perf_counter()
                found = await directory.search()
                times.append((time.perf_counter() - began) * 1e3)
                if len(found) != wanted:
                    raise RuntimeError(f"the search found {len(found)} agents of {wanted}")
    return times


async def _until_known(bus: ZenohBus, number: int, platform: str) -> None:
    """Wait until so many agents of platforms that begin so are there."""
    deadline = time.monotonic() + MEETING_TIME_S
    with Directory(bus) as directory:
        while sum(name.platform.startswith(platform) for name in directory.names) < number:
            if time.monotonic() > deadline:
                raise TimeoutError(f"{number} agents on {platform} were not seen in {MEETING_TIME_S} s")
            await asyncio.sleep(0.02)


@contextmanager
def _router() -> Iterator[None]:
    command = [sys.executable, "-m", "acromovi", "router", "--listen", ROUTER_ADDRESS]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        process.stdout.readline()
        try:
            yield
        finally:
            process.terminate()


_PROFILE = f"""
mode = "client"
listen.endpoints = []
connect.endpoints = [{json.dumps(ROUTER_ADDRESS)}]
scouting.multicast.enabled = false
scouting.gossip.enabled = false
transport.link.tx.lease = 1000
"""

"""`acromovi navigate up` on a bus with a router, when that goes and comes back."""

import json
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from socket import create_server

from bus import BusError, ZenohBus
from configs import find
from tests.acromovi.team.running import ROOT
from tests.agents.faults.processes import running
from tests.waiting import wait_until

CONTAINER = "happy/containers/happy-monitor/description"


def router_profile(folder: Path) -> tuple[str, str]:
    """A profile of clients of a router, and where that listens."""
    with create_server(("127.0.0.1", 0)) as probe:
        address = f"tcp/127.0.0.1:{probe.getsockname()[1]}"
    path = folder / "router.toml"
    path.write_text(find("bus", "router").read_text().replace("tcp/127.0.0.1:7447", address))
    return str(path), address


@contextmanager
def navigation(profile: str, complaints: Path) -> Iterator[None]:
    """One process of a navigation, which is up."""
    command = [sys.executable, "-m", "acromovi", "navigate", "up", "happy", "--process", "monitor", "--json"]
    with (
        complaints.open("w") as stderr,
        subprocess.Popen(
            [*command, "--bus", profile], cwd=ROOT, stdout=subprocess.PIPE, stderr=stderr, text=True
        ) as up,
    ):
        try:
            assert up.stdout is not None
            assert json.loads(up.stdout.readline())["robot"] == "happy"
            yield
        finally:
            up.terminate()


def process_of(bus: ZenohBus) -> int:
    """The process that answers for the container; 0 while none does."""
    try:
        (answer,) = bus.query(CONTAINER, {"do": "list"}, 1.0)
    except BusError:
        return 0
    return int(answer.value["process"])


def test_processes_outlive_the_bus_and_are_the_same_when_it_is_back(tmp_path: Path) -> None:
    profile, address = router_profile(tmp_path)
    complaints = tmp_path / "complaints"
    with ExitStack() as stack:
        router = stack.enter_context(running("acromovi", "router", "--listen", address, says="routing"))
        stack.enter_context(navigation(profile, complaints))
        bus = stack.enter_context(ZenohBus.open(profile))
        before = process_of(bus)
        assert before
        router.kill()
        router.wait()
        wait_until(lambda: "monitor of happy runs, but is not on the bus" in complaints.read_text(), "it is missed")
        stack.enter_context(running("acromovi", "router", "--listen", address, says="routing"))
        wait_until(lambda: "all processes are on the bus again" in complaints.read_text(), "it is heard of again")
        wait_until(lambda: process_of(bus) == before, "it is the same process")
        assert len(complaints.read_text().splitlines()) == 2

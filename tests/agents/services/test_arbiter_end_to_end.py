"""Gateway, arbiter and the holder of a lease as processes, and the cable on which the wheels are told to stop."""

import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from acromovi.children import gateway
from benchmarks.peer import CableRobot
from bus import Bus, Refused, Sample, ZenohBus, keys
from bus.messages import decode, twist
from tests.live_team import LiveTeam, environment, own_bus
from tests.waiting import wait_until

ROBOT = "cable"
SOON = 5.0  # s; the lease would last for thirty

HOLDER = """
import asyncio, sys
from agents.platform import Agent, Container
from agents.services.lease_client import find_arbiter, leased
from bus import ZenohBus, keys, messages

async def main(profile, robot):
    with ZenohBus.open(profile) as bus:
        async with Container(bus, "holder") as container:
            agent = Agent("holder@lab")
            await container.start(agent)
            while (arbiter := await find_arbiter(agent)) is None:
                await asyncio.sleep(0.1)
            while "does not answer" in (await agent.request(arbiter, "lease", element=f"nothing@{robot}")).why:
                await asyncio.sleep(0.1)  # arbiter and gateway have not met yet
            async with leased(agent, f"base@{robot}", seconds=30.0, arbiter=arbiter) as lease:
                print(lease.token, flush=True)
                while True:
                    bus.put(keys.CMD_VEL.key(robot), messages.twist(0.3, 0.0), lease.token.encode())
                    await asyncio.sleep(0.05)

asyncio.run(main(*sys.argv[1:]))
"""


@pytest.fixture
def site(tmp_path: Path) -> Iterator[LiveTeam]:
    """A bus of its own, with an arbiter that writes down what it does."""
    site = own_bus(tmp_path)
    words = ["acromovi", "container", "--services", "team", "--property", "arbiter.audit_file=leases.jsonl", "--json"]
    with site.running(*words) as services:
        assert services.stdout is not None
        assert services.stdout.readline(), services.communicate()[1]
        yield site


@contextmanager
def holder(site: LiveTeam) -> "Iterator[tuple[subprocess.Popen[str], str]]":
    """A process that drives with a lease, and its token."""
    command = [sys.executable, "-c", HOLDER, str(site.bus), ROBOT]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment()) as process:
        try:
            assert process.stdout is not None
            yield process, process.stdout.readline().strip()
        finally:
            process.kill()


def take_when_free(bus: Bus) -> str:
    """Become the next holder; the token."""
    lease = keys.LEASE.key(ROBOT)
    wait_until(lambda: bus.query(lease)[0].value["elements"] == {}, "the lease has ended")
    token: str = bus.query(lease, {"do": "take", "holder": "next", "element": "base", "seconds": 60.0})[0].value[
        "token"
    ]
    return token


def test_holder_killed_while_driving_is_stopped_and_its_token_moves_nothing_any_more(site: LiveTeam) -> None:
    with (
        CableRobot(ROBOT) as robot,
        gateway(robot.port, "--name", ROBOT, "--bus", str(site.bus), "--quiet"),
        ZenohBus.open(str(site.bus)) as bus,
    ):
        with holder(site) as (process, token):
            assert token
            wait_until(lambda: robot.speed > 0.0)
            process.kill()
            killed = time.monotonic()
            wait_until(lambda: robot.speed == 0.0)
        stopped = next(at for at, speed in robot.velocities if at > killed and speed == 0.0)
        assert stopped - killed < SOON
        new = take_when_free(bus)
        bus.put(keys.CMD_VEL.key(ROBOT), twist(0.3, 0.0), token.encode())
        drive = {"linear": 0.2, "angular": 0.0}
        with pytest.raises(Refused, match="next holds the lease on the base"):
            bus.query(keys.DRIVE.key(ROBOT), {**drive, "token": token})
        bus.query(keys.DRIVE.key(ROBOT), {**drive, "token": new})
        wait_until(lambda: robot.speed == 0.2)
        assert all(speed != 0.3 for at, speed in robot.velocities if at > stopped)

        listed = site.run("acromovi", "leases", "--audit", "50")
        assert listed.returncode == 0, listed.stderr
        assert f"base@{ROBOT}  next" in listed.stdout
        record = [line.split() for line in listed.stdout.splitlines()]
        events = [words[1] for words in record if words[2:4] == [f"base@{ROBOT}", "holder@lab"]]
        assert events == ["granted", "died"]
    assert '"event": "died"' in (site.folder / "leases.jsonl").read_text()


def test_holder_frozen_while_driving_loses_the_lease_and_moves_nothing_once_it_is_thawed(site: LiveTeam) -> None:
    faults: set[str] = set()

    def hear(sample: Sample) -> None:
        faults.update(decode(keys.STATE.type_name, sample.payload).faults)

    with (
        CableRobot(ROBOT) as robot,
        gateway(robot.port, "--name", ROBOT, "--bus", str(site.bus), "--quiet"),
        ZenohBus.open(str(site.bus)) as bus,
        holder(site) as (process, _),
        bus.subscribe(keys.STATE.key(ROBOT), hear),
    ):
        wait_until(lambda: robot.speed > 0.0)
        process.send_signal(signal.SIGSTOP)
        wait_until(lambda: robot.speed == 0.0)
        take_when_free(bus)  # long before the thirty seconds are over
        taken = time.monotonic()
        process.send_signal(signal.SIGCONT)
        wait_until(lambda: any("next holds the lease on the base" in fault for fault in faults), "it was refused")
        assert all(speed == 0.0 for at, speed in robot.velocities if at > taken)

"""Two sites, a robot behind each, routers that dial each other: the line between them is cut and comes back."""

import json
import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from typing import Any

import pytest

from tests.sites.lab import CABLE, NoNamespaces, Site, two_sites
from tests.waiting import Deadline

ROBOTS = ("happy", "doc")


class Onlooker:
    """Someone at one site, asked from here."""

    def __init__(self, process: "subprocess.Popen[str]") -> None:
        self._process = process

    def hear(self) -> dict[str, Any]:
        assert self._process.stdout is not None
        said: dict[str, Any] = json.loads(self._process.stdout.readline())
        return said

    def ask(self, **question: Any) -> dict[str, Any]:
        assert self._process.stdin is not None
        self._process.stdin.write(json.dumps(question) + "\n")
        self._process.stdin.flush()
        return self.hear()

    def until(self, condition: Callable[[dict[str, Any]], bool], **question: Any) -> dict[str, Any]:
        """Ask until the answer is as wanted; the last answer when it is not in time."""
        deadline = Deadline()
        while not condition(answer := self.ask(**question)) and not deadline.has_passed():
            time.sleep(0.05)
        return answer

    def sees(self, *robots: str) -> bool:
        """Whether it comes to see a base of each of these robots, and of no others, each once."""
        wanted = sorted(f"base@{robot}" for robot in robots)

        def is_so(answer: dict[str, Any]) -> bool:
            return [name for name in answer["names"] if name.startswith("base@")] == wanted

        return is_so(self.until(is_so, names=True))

    def reaches(self, agent: str) -> bool:
        """Whether an agent comes to answer; the first question after a change may be lost on the way."""
        wanted = {"ending": "done"}
        return self.until(wanted.__eq__, ask=agent, request="read") == wanted

    def hears_more(self, robot: str) -> bool:
        """Whether more poses of a robot come."""
        before = self.ask(count=True)[robot][0]
        return bool(self.until(lambda answer: answer[robot][0] > before + 5, count=True)[robot][0] > before + 5)


class World:
    """Both sites at work."""

    def __init__(self, sites: tuple[Site, Site], stack: ExitStack) -> None:
        self._sites = sites
        waiting = []
        for site, other in (sites, sites[::-1]):
            listen = ["--listen", f"tcp/{site.address}:7447", "--listen", "tcp/127.0.0.1:7447"]
            router = stack.enter_context(
                site.program("acromovi", "router", *listen, "--connect", f"tcp/{other.address}:7447")
            )
            assert router.stdout is not None
            waiting.append(router.stdout)
        for stream in waiting:
            assert stream.readline().startswith("routing")
        for site, robot in zip(sites, ROBOTS, strict=True):
            emulator = stack.enter_context(
                site.program("p2os_emu", "--robot", f"p3dx-sh:{robot}", "--world", "empty", "--json")
            )
            assert emulator.stdout is not None
            port = json.loads(emulator.stdout.readline())["robots"][0]["port"]
            stack.enter_context(site.program("gateway", port, "--bus", "router", "--quiet", "--name", robot))
            stack.enter_context(site.program("acromovi", "container", "--robot", robot, "--bus", "router"))
        self.here, self.there = [
            Onlooker(stack.enter_context(site.program("tests.sites.onlooker", *robots)))
            for site, robots in zip(sites, (ROBOTS, ROBOTS[::-1]), strict=True)
        ]
        for onlooker in (self.here, self.there):
            assert onlooker.hear() == {"ready": True}

    def cut(self) -> None:
        self._sites[0].tell("ip", "link", "set", CABLE, "down")

    def mend(self) -> None:
        self._sites[0].tell("ip", "link", "set", CABLE, "up")


@pytest.fixture
def world() -> Iterator[World]:
    with ExitStack() as stack:
        try:
            sites = stack.enter_context(two_sites())
        except NoNamespaces as error:
            pytest.skip(f"no network namespaces here: {error}")
        yield World(sites, stack)


def test_two_sites_go_on_when_the_line_between_them_is_cut_and_heal(world: World) -> None:
    here, there = world.here, world.there
    assert here.sees(*sorted(ROBOTS))
    assert there.sees(*sorted(ROBOTS))
    for onlooker in (here, there):
        onlooker.ask(listen=True)
    assert here.reaches("base@doc")
    assert there.reaches("base@happy")
    assert here.hears_more("doc")
    assert there.hears_more("happy")

    world.cut()
    assert here.sees("happy")
    assert there.sees("doc")
    assert here.ask(ask="base@doc", request="read")["ending"] in ("peer died", "timed out")
    assert here.reaches("base@happy")
    assert there.reaches("base@doc")
    assert here.hears_more("happy")
    assert there.hears_more("doc")

    world.mend()
    assert here.sees(*sorted(ROBOTS))
    assert there.sees(*sorted(ROBOTS))
    assert here.reaches("base@doc")
    assert there.reaches("base@happy")
    assert here.hears_more("doc")
    assert there.hears_more("happy")
    for onlooker in (here, there):
        found = onlooker.ask(search="doc")["found"]
        assert found == sorted(set(found))
        assert "base@doc" in found
        assert [doubled for _, doubled in onlooker.ask(count=True).values()] == [0, 0]

"""The profile `local` on a machine with a network: programs of this machine are found, and nobody else."""

import json
import subprocess
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from functools import partial
from typing import Any

import pytest

from tests.sites.lab import NoNamespaces, Site, two_sites

Until = Callable[..., None]


class Peer:
    """A program at one of the sites."""

    def __init__(self, stack: ExitStack, site: Site, kind: str, name: str) -> None:
        self._process: subprocess.Popen[str] = stack.enter_context(
            site.program("tests.sites.network_peer", kind, name, site.address)
        )
        assert self.hear() == "ready"

    def begin(self, do: str, **given: Any) -> None:
        assert self._process.stdin is not None
        self._process.stdin.write(json.dumps({"do": do, **given}) + "\n")
        self._process.stdin.flush()

    def hear(self) -> Any:
        assert self._process.stdout is not None
        return json.loads(self._process.stdout.readline())

    def ask(self, do: str, **given: Any) -> Any:
        self.begin(do, **given)
        return self.hear()

    def sees(self, *names: str) -> bool:
        """Whether it gets answers from these, and from nobody else."""
        return bool(self.ask("look") == sorted(f"{name}/here" for name in names))


@pytest.fixture
def sites() -> Iterator[tuple[Site, Site]]:
    try:
        with two_sites() as sites:
            yield sites
    except NoNamespaces as error:
        pytest.skip(f"this machine makes no network namespaces: {error}")


@pytest.fixture
def stack() -> Iterator[ExitStack]:
    with ExitStack() as stack:
        yield stack


@pytest.mark.parametrize("first", ["ours", "plain"])
def test_a_program_with_zenohs_default_configuration_meets_ours_on_the_same_machine(
    sites: tuple[Site, Site], stack: ExitStack, until: Until, first: str
) -> None:
    second = "plain" if first == "ours" else "ours"
    peers = {kind: Peer(stack, sites[0], kind, kind) for kind in (first, second)}
    for peer in peers.values():
        until(partial(peer.sees, "ours", "plain"), "both see each other")


def test_a_stranger_on_the_network_neither_finds_nor_reaches_a_local_bus(
    sites: tuple[Site, Site], stack: ExitStack, until: Until
) -> None:
    here, there = sites
    ours = Peer(stack, here, "ours", "ours")
    second = Peer(stack, here, "ours", "second")
    beside = Peer(stack, here, "plain", "beside")  # it has joined Zenoh's multicast group on the outer interface
    stranger = Peer(stack, there, "plain", "stranger")
    until(partial(stranger.sees, "beside", "stranger"), "the network carries what it should")
    until(partial(ours.sees, "ours", "second", "beside"), "all of this machine meet")

    open_ports = [*ours.ask("sockets"), *second.ask("sockets")]
    assert open_ports
    assert all(address.startswith("127.") for address, _ in open_ports)
    every_port = [port for peer in (ours, second, beside) for _, port in peer.ask("sockets")]
    assert stranger.ask("attack", address=here.address, ports=every_port, seconds=2.0) == "done"

    until(partial(stranger.sees, "beside", "stranger"), "the stranger is still where it was")
    for peer in (ours, second):
        assert peer.sees("ours", "second", "beside")


def test_a_local_bus_sends_nothing_to_the_network(sites: tuple[Site, Site], stack: ExitStack, until: Until) -> None:
    here, there = sites
    listener = Peer(stack, there, "ours", "listener")
    listener.begin("listen", seconds=3.0)  # while programs come, scout and go
    assert listener.hear() == "listening"
    ours = Peer(stack, here, "ours", "ours")
    with ExitStack() as short:
        Peer(short, here, "ours", "second")
        until(partial(ours.sees, "ours", "second"), "they meet")
    until(partial(ours.sees, "ours"), "the second has gone")
    assert listener.hear() == []

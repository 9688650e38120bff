"""Sessions on one machine find each other by an entry that each makes before it opens."""

import signal
import socket
import subprocess
import sys
import threading
import time
import uuid
from collections.abc import Callable
from contextlib import ExitStack, closing, suppress
from pathlib import Path
from types import SimpleNamespace

import pytest

import bus.loopback
from bus import BusUnavailable, NoAnswer, ZenohBus
from bus.loopback import LocalBus, Registration
from configs import ConfigError
from configs.defaults import VARIABLE, default_bus

ROOT = Path(__file__).resolve().parents[2]
Until = Callable[..., None]

LATE = 2.5  # s, which a process may be on a busy machine

SERVES = """
import sys
from bus import ZenohBus
with ZenohBus.open(sys.argv[1]) as bus:
    bus.serve(sys.argv[2], lambda given: {"ok": True})
    tokens = [bus.declare_alive(key) for key in sys.argv[3:]]
    print("ready", flush=True)
    sys.stdin.read()
"""


@pytest.fixture
def name() -> str:
    """A bus of this test's own."""
    return f"test-{uuid.uuid4().hex[:12]}"


def serving(stack: ExitStack, name: str, key: str, *tokens: str) -> "subprocess.Popen[str]":
    """A process that answers on a key, and shows tokens."""
    command = [sys.executable, "-c", SERVES, f"local:{name}", key, *tokens]
    process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=ROOT)
    stack.enter_context(process)
    stack.callback(process.kill)
    stack.callback(process.send_signal, signal.SIGCONT)
    assert process.stdout is not None
    assert process.stdout.readline() == "ready\n"
    return process


def test_each_bus_has_a_loopback_address_and_a_scouting_port_that_follow_from_its_name() -> None:
    buses = [LocalBus(), *map(LocalBus.named, ("a", "b", "lab-2.dwarfs", "x" * 40))]
    assert len({bus.address for bus in buses}) == len({bus.scouting_address for bus in buses}) == len(buses)
    assert all(bus.address.startswith("127.") and bus.address != "127.0.0.1" for bus in buses)
    assert LocalBus.named("a").address == LocalBus("a").address
    assert LocalBus().scouting_address == ("224.0.0.224", 7446)  # where Zenoh looks by default


@pytest.mark.parametrize("name", ["a/b", "-a", "a b", "x" * 41, "ä", "a\0b", "a\n"])
def test_a_name_that_cannot_be_a_bus_is_refused(name: str) -> None:
    with pytest.raises(ConfigError, match="is not a valid name of a local bus; use 1 to 40 letters"):
        ZenohBus.open(f"local:{name}")


def test_a_session_is_to_connect_to_all_that_registered_before_it_and_still_live(name: str) -> None:
    local = LocalBus(name)
    with Registration(local) as first, Registration(local) as second, Registration(local) as third:
        assert third.elders == (first.endpoint, second.endpoint)
        second.close()
        with Registration(local) as fourth, Registration(LocalBus(f"{name}-other")) as stranger:
            assert fourth.elders == (first.endpoint, third.endpoint)
            assert stranger.elders == ()
    assert local.entries() == []


def test_of_any_two_that_register_at_the_same_time_one_connects_to_the_other(name: str) -> None:
    together = threading.Barrier(16)
    made: list[Registration] = []

    def register() -> None:
        together.wait()
        made.append(Registration(LocalBus(name)))

    threads = [threading.Thread(target=register) for _ in range(together.parties)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    with ExitStack() as stack:
        for registration in made:
            stack.enter_context(registration)
        assert len({registration.endpoint for registration in made}) == len(made)
        for one in made:
            for other in made:
                assert one is other or one.endpoint in other.elders or other.endpoint in one.elders
            one_way = [other for other in made if other.endpoint in one.elders and one.endpoint in other.elders]
            assert not one_way, "two that connect to each other"


@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGTERM])
def test_the_entry_of_a_process_goes_with_it(name: str, until: Until, how: signal.Signals) -> None:
    with ExitStack() as stack:
        process = serving(stack, name, "a/b")
        assert len(LocalBus(name).entries()) == 1
        process.send_signal(how)
        until(lambda: LocalBus(name).entries() == [])


def test_programs_on_buses_of_different_names_do_not_meet(name: str, robot: str) -> None:
    with ExitStack() as stack:
        serving(stack, name, f"{robot}/q")
        with ZenohBus.open(f"local:{name}") as same, ZenohBus.open(f"local:{name}-other") as other:
            assert same.query(f"{robot}/q")[0].value == {"ok": True}
            with pytest.raises(NoAnswer):
                other.query(f"{robot}/q")


def test_the_first_query_reaches_everybody(name: str, robot: str) -> None:
    with ExitStack() as stack:
        for number in range(4):
            serving(stack, name, f"{robot}/q/{number}")
        with ZenohBus.open(f"local:{name}") as bus:
            assert len(bus.query(f"{robot}/q/*")) == 4


def test_the_first_query_reaches_one_to_which_the_session_is_connected_late(name: str, robot: str) -> None:
    with ExitStack() as stack:
        late = serving(stack, name, f"{robot}/q/0")
        serving(stack, name, f"{robot}/q/1")
        late.send_signal(signal.SIGSTOP)
        with ZenohBus.open(f"local:{name}") as bus:
            threading.Timer(0.5, late.send_signal, (signal.SIGCONT,)).start()
            answers = bus.query(f"{robot}/q/*", timeout=20.0)
            assert {answer.key for answer in answers} == {f"{robot}/q/0", f"{robot}/q/1"}


def test_one_that_is_stopped_holds_up_nobody_who_asks_all(name: str, robot: str) -> None:
    with ExitStack() as stack:
        stopped = serving(stack, name, f"{robot}/q/0")
        serving(stack, name, f"{robot}/q/1")
        stopped.send_signal(signal.SIGSTOP)
        with ZenohBus.open(f"local:{name}") as bus:
            (answer,) = bus.query(f"{robot}/q/*", timeout=20.0)
            assert answer.key == f"{robot}/q/1"
            (answer,) = bus.query(f"{robot}/q/*", timeout=0.2)  # shorter than a session waits for those it has not met
            assert answer.key == f"{robot}/q/1"


def test_one_that_is_stopped_holds_up_nobody_who_opens(name: str, robot: str, until: Until) -> None:
    with ExitStack() as stack:
        stopped = serving(stack, name, f"{robot}/stopped")
        serving(stack, name, f"{robot}/q")
        stopped.send_signal(signal.SIGSTOP)
        began = time.monotonic()
        with ZenohBus.open(f"local:{name}") as bus:
            assert time.monotonic() - began < 10.0
            assert bus.query(f"{robot}/q")[0].value == {"ok": True}
            stopped.send_signal(signal.SIGCONT)

            def answers() -> bool:
                with suppress(NoAnswer):  # the sessions do not know each other yet
                    return bus.query(f"{robot}/stopped")[0].value == {"ok": True}
                return False

            until(answers)


def test_a_port_that_is_taken_meanwhile_is_replaced_by_another(monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    address = LocalBus(name).address
    with socket.create_server((address, 0)) as taken:
        ports = [taken.getsockname()[1]]
        on_free_port = bus.loopback._on_free_port

        def first_the_taken_one(where: str) -> object:
            if not ports:
                return on_free_port(where)
            port = ports.pop()
            return SimpleNamespace(getsockname=lambda: (where, port), close=lambda: None)

        monkeypatch.setattr(bus.loopback, "_on_free_port", first_the_taken_one)
        with ZenohBus.open(f"local:{name}"):
            assert not ports
            assert len(LocalBus(name).entries()) == 1


def test_a_session_holds_the_ports_of_the_entries_that_it_has_withdrawn(
    monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    local = LocalBus(name)
    tried: list[int] = []
    on_free_port = bus.loopback._on_free_port
    with socket.socket(socket.AF_UNIX) as later:

        def while_another_one_registers(address: str) -> socket.socket:
            probe = on_free_port(address)
            if not tried:
                later.bind(f"\0{local._registry}9/1")
            tried.append(probe.getsockname()[1])
            return probe

        monkeypatch.setattr(bus.loopback, "_on_free_port", while_another_one_registers)
        with Registration(local) as registration:
            withdrawn, own = tried
            assert registration.endpoint.endswith(f":{own}")
            with pytest.raises(OSError, match="in use"):
                socket.create_server((local.address, withdrawn))
            socket.create_server((local.address, own)).close()
    socket.create_server((local.address, withdrawn)).close()


def test_a_session_does_not_take_the_port_of_one_that_does_not_listen_yet(
    monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    local = LocalBus(name)
    with Registration(local) as first:
        ports = [int(first.endpoint.rpartition(":")[2])]
        on_free_port = bus.loopback._on_free_port

        def first_the_same(address: str) -> socket.socket:
            if not ports:
                return on_free_port(address)
            probe = socket.socket()
            probe.bind((address, ports.pop()))
            return probe

        monkeypatch.setattr(bus.loopback, "_on_free_port", first_the_same)
        with Registration(local) as second:
            assert not ports
            assert second.endpoint != first.endpoint
            assert second.elders == (first.endpoint,)


def test_a_machine_that_hides_its_sockets_is_told_in_one_sentence(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, name: str
) -> None:
    monkeypatch.setattr(bus.loopback, "SOCKETS", tmp_path / "unix")
    with pytest.raises(BusUnavailable, match="needs /proc to find other programs"):
        ZenohBus.open(f"local:{name}")
    (tmp_path / "unix").write_text("Num RefCount\n")
    with pytest.raises(BusUnavailable, match="does not show this program's own sockets"):
        ZenohBus.open(f"local:{name}")


def test_the_default_bus_is_that_of_the_environment(monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    monkeypatch.setenv(VARIABLE, f"local:{name}")
    with closing(ZenohBus.open()):
        assert len(LocalBus(name).entries()) == 1
    monkeypatch.setenv(VARIABLE, "")
    assert default_bus() == "local"


def test_one_that_is_late_keeps_its_token(name: str, robot: str, until: Until) -> None:
    changes: list[bool] = []
    with ExitStack() as stack:
        late = serving(stack, name, f"{robot}/q", f"{robot}/alive")
        bus = stack.enter_context(ZenohBus.open(f"local:{name}"))
        bus.watch_alive(f"{robot}/alive", lambda key, is_alive: changes.append(is_alive))
        until(lambda: changes == [True], "they have met")
        late.send_signal(signal.SIGSTOP)
        time.sleep(LATE)
        late.send_signal(signal.SIGCONT)
        assert bus.query(f"{robot}/q")[0].value == {"ok": True}
        assert changes == [True]


@pytest.mark.parametrize("first", ["the frozen one", "the other"])
def test_one_that_was_frozen_for_longer_than_the_lease_is_met_again(
    name: str, robot: str, until: Until, first: str
) -> None:
    changes: list[bool] = []
    with ExitStack() as stack:
        early = stack.enter_context(ZenohBus.open(f"local:{name}")) if first == "the other" else None
        frozen = serving(stack, name, f"{robot}/q", f"{robot}/alive")
        bus = early or stack.enter_context(ZenohBus.open(f"local:{name}"))
        bus.watch_alive(f"{robot}/alive", lambda key, is_alive: changes.append(is_alive))
        until(lambda: changes == [True], "they have met")
        frozen.send_signal(signal.SIGSTOP)
        until(lambda: changes == [True, False], "it counts as dead")
        frozen.send_signal(signal.SIGCONT)
        until(lambda: changes == [True, False, True], "it is met again")
        assert bus.query(f"{robot}/q")[0].value == {"ok": True}

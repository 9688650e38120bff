"""What only the bus between processes does: profiles, foreign programs, processes that die."""

import json
import signal
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import zenoh

from bus import BusUnavailable, NoAnswer, Refused, Sample, ZenohBus
from bus.messages import encode, twist
from bus.secure import Profile
from bus.session import configuration
from configs import ConfigError
from configs.loader import find, names, read
from tests.plain_zenoh import plain_session
from tests.waiting import run

ROOT = Path(__file__).resolve().parents[2]
Until = Callable[..., None]

SHOWS_A_TOKEN = """
import sys
from bus import ZenohBus
with ZenohBus.open() as bus:
    bus.declare_alive(sys.argv[1])
    print("ready", flush=True)
    sys.stdin.read()
"""


@pytest.fixture
def stranger() -> Iterator[zenoh.Session]:
    """A program that knows Zenoh and nothing of ours."""
    with plain_session() as session:
        yield session


@pytest.fixture
def other_process(robot: str) -> Iterator[subprocess.Popen[str]]:
    """A process that shows the robot's token."""
    process = subprocess.Popen(
        [sys.executable, "-c", SHOWS_A_TOKEN, f"{robot}/alive"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        cwd=ROOT,
    )
    with process:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        yield process
        process.send_signal(signal.SIGCONT)
        process.kill()


# Those with keys are in test_secure_bus.
@pytest.mark.parametrize("profile", [name for name in names("bus") if not name.startswith("secure")])
def test_zenoh_takes_every_profile(profile: str) -> None:
    configuration(profile)


def test_a_local_bus_listens_on_the_loopback_interface_only() -> None:
    before = _listening()
    with ZenohBus.open():
        opened = _listening() - before
        assert len(opened) == 2, "one address for other sessions, and one at which plain Zenoh programs are answered"
        # As /proc/net/tcp writes 127.*
        assert all(address.partition(":")[0].endswith("7F") for address in opened), opened


def _listening() -> set[str]:
    """The addresses on which this process listens for TCP, and those of its UDP sockets, as the kernel writes them."""
    own = {str(fd.readlink()) for fd in list(Path("/proc/self/fd").iterdir()) if fd.is_socket()}
    tables = ("tcp", "tcp6", "udp", "udp6")
    rows = [line.split() for table in tables for line in Path(f"/proc/net/{table}").read_text().splitlines()]
    listening = ("0A", "07")  # as TCP does, and any UDP socket
    return {row[1] for row in rows if row[3] in listening and f"socket:[{row[9]}]" in own}


def test_a_stranger_reads_the_type_from_the_encoding(
    zenoh_meeting: Any, stranger: zenoh.Session, robot: str, until: Until
) -> None:
    heard: list[zenoh.Sample] = []
    bus = zenoh_meeting.join()
    stranger.declare_subscriber(f"{robot}/*", heard.append)
    publisher = bus.publisher(f"{robot}/cmd_vel", "geometry_msgs/msg/Twist")

    def has_met() -> bool:
        publisher.put(twist(0.5, 0.0), b"token")
        return bool(heard)

    until(has_met)
    assert heard[0].encoding == zenoh.Encoding.APPLICATION_CDR.with_schema("geometry_msgs/msg/Twist")
    assert heard[0].payload.to_bytes() == encode(twist(0.5, 0.0))
    assert heard[0].attachment is not None
    assert heard[0].attachment.to_bytes() == b"token"


def test_a_stranger_is_heard_whatever_it_puts(
    zenoh_meeting: Any, stranger: zenoh.Session, robot: str, until: Until
) -> None:
    heard: list[Sample] = []
    zenoh_meeting.join().subscribe(f"{robot}/x", heard.append)

    def has_met() -> bool:
        stranger.delete(f"{robot}/x")
        stranger.put(f"{robot}/x", b"\xff\x00")
        return bool(heard)

    until(has_met)
    assert heard[0] == Sample(f"{robot}/x", b"\xff\x00", "zenoh/bytes", b"")
    assert all(sample.payload for sample in heard), "a deletion is no message"


@pytest.mark.parametrize("payload", [b"{", b"[1]", b"\xff", b'{"a": 1} x'])
def test_a_query_without_a_json_object_gets_an_error_reply(
    zenoh_meeting: Any, stranger: zenoh.Session, robot: str, until: Until, payload: bytes
) -> None:
    zenoh_meeting.join().serve(f"{robot}/q", lambda arguments: {"ok": True})
    until(lambda: any(reply.ok for reply in stranger.get(f"{robot}/q", timeout=5.0)))
    (reply,) = stranger.get(f"{robot}/q", payload=payload, timeout=5.0)
    assert reply.err is not None
    assert "JSON" in json.loads(reply.err.payload.to_bytes())["error"]


def test_a_strangers_error_reply_is_quoted(
    zenoh_meeting: Any, stranger: zenoh.Session, robot: str, until: Until
) -> None:
    def refuse(query: zenoh.Query) -> None:
        with query:
            query.reply_err(b"not today")

    stranger.declare_queryable(f"{robot}/q", refuse)
    bus = zenoh_meeting.join()
    with pytest.raises(Refused, match=r"^not today$"):
        bus.query(f"{robot}/q")


def test_an_answerer_that_takes_too_long_is_no_answer(zenoh_meeting: Any, stranger: zenoh.Session, robot: str) -> None:
    kept: list[zenoh.Query] = []
    stranger.declare_queryable(f"{robot}/q", kept.append)
    bus = zenoh_meeting.join()
    with pytest.raises(NoAnswer, match=r"has not answered within 0\.2 s"):
        bus.query(f"{robot}/q", timeout=0.2)


def test_a_query_right_after_opening_waits_for_the_others(zenoh_meeting: Any, robot: str) -> None:
    zenoh_meeting.join().serve(f"{robot}/q", lambda arguments: {"ok": True})
    assert zenoh_meeting.join().query(f"{robot}/q")[0].value == {"ok": True}


@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGSTOP])
def test_a_process_that_is_killed_or_frozen_loses_its_token(
    zenoh_meeting: Any, other_process: "subprocess.Popen[str]", robot: str, until: Until, how: signal.Signals
) -> None:
    changes: list[bool] = []
    zenoh_meeting.join().watch_alive(f"{robot}/alive", lambda key, is_alive: changes.append(is_alive))
    until(lambda: changes == [True])
    other_process.send_signal(how)
    until(lambda: changes == [True, False])


def test_a_program_that_forgets_to_close_ends_all_the_same(robot: str) -> None:
    program = f"from bus import ZenohBus; bus = ZenohBus.open(); bus.subscribe('{robot}/x', print)"
    assert run([sys.executable, "-c", program], cwd=ROOT).returncode == 0


def test_clients_of_a_router_meet_through_it(robot: str) -> None:
    with socket.create_server(("127.0.0.1", 0)) as probe:
        address = f"tcp/127.0.0.1:{probe.getsockname()[1]}"
    client = configuration("router", {"connect/endpoints": [address]})
    with pytest.raises(BusUnavailable, match="cannot be opened"):
        ZenohBus(client)
    with (
        ZenohBus(configuration("site", {"listen/endpoints": [address]})),
        ZenohBus(client) as one,
        ZenohBus(client) as other,
        ZenohBus.open() as local,
    ):
        one.serve(f"{robot}/q", lambda arguments: {"ok": True})
        assert other.query(f"{robot}/q")[0].value == {"ok": True}
        with pytest.raises(NoAnswer):  # what keeps to this machine does so with a router here as well
            local.query(f"{robot}/q")


def test_a_taken_address_is_told_in_one_sentence() -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        address = f"tcp/127.0.0.1:{taken.getsockname()[1]}"
        with pytest.raises(BusUnavailable, match=r"^the bus cannot be opened: .*Address already in use") as caught:
            ZenohBus(configuration("site", {"listen/endpoints": [address]}))
    assert "\n" not in str(caught.value)


def test_an_unknown_profile_names_the_nearest() -> None:
    with pytest.raises(ConfigError, match="local"):
        configuration("locl")


@pytest.mark.parametrize(
    ("name", "text", "why"),
    [
        ("bus.toml", 'mood = "peer"', "unknown field `mood`"),
        ("bus.toml", 'mode = "peer', "is not TOML"),
        ("bus.json5", '{mood: "peer"}', "unknown field `mood`"),
    ],
)
def test_a_wrong_profile_names_file_and_reason(tmp_path: Path, name: str, text: str, why: str) -> None:
    path = tmp_path / name
    path.write_text(text)
    with pytest.raises(ConfigError, match=why) as caught:
        configuration(str(path))
    assert str(path) in str(caught.value)


def test_zenohs_own_file_serves_as_a_profile(tmp_path: Path) -> None:
    path = tmp_path / "mine.json5"
    path.write_text('{mode: "client"}  // Zenoh\'s own form')
    assert configuration(str(path)).get_json("mode") == '"client"'


def test_lan_warns_once_that_everybody_can_drive_the_robots_and_how_to_prevent_it(tmp_path: Path) -> None:
    assert Profile.find("lan").warning.startswith("bus profile lan: everybody on this network can drive the robots")
    table = read(find("bus", "lan"))
    file = tmp_path / "quiet.toml"  # the same without a network
    file.write_text(
        'mode = "peer"\nlisten.endpoints = ["tcp/127.0.0.1:0"]\nscouting.multicast.enabled = false\n'
        f"[acromovi]\nwarning = {json.dumps(table['acromovi']['warning'])}\n"
    )
    script = "import sys\nfrom bus import ZenohBus\nfor _ in range(2): ZenohBus.open(sys.argv[1]).close()"
    done = run([sys.executable, "-c", script, str(file)], cwd=ROOT)
    assert done.returncode == 0, done.stderr
    (line,) = done.stderr.splitlines()
    assert "acromovi keys" in line

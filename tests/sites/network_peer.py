"""A program on a bus, told by lines of JSON what to do: `python -m tests.sites.network_peer ours|plain NAME ADDRESS`.

`ours` uses the profile local; `plain` is a Zenoh program with Zenoh's default configuration.
"""

import json
import socket
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import zenoh

from bus import ZenohBus
from bus.loopback import LocalBus
from bus.scouting import SCOUT, hello

TCP_LISTENS, UDP = "0A", "07"
IGNORED = 0x0806, 0x86DD  # ARP and IPv6, of which the kernel sends some by itself
EVERYTHING = 3  # ETH_P_ALL


@contextmanager
def opened(kind: str) -> Iterator[zenoh.Session]:
    if kind == "plain":
        with zenoh.open(zenoh.Config()) as session:
            yield session
    else:
        with ZenohBus.open("local") as bus:
            yield bus._session


def sockets() -> list[tuple[str, int]]:
    """Where this process receives TCP connections and UDP datagrams: addresses and ports."""
    own = {str(fd.readlink()) for fd in list(Path("/proc/self/fd").iterdir()) if fd.is_socket()}
    found = []
    for table, state in (("tcp", TCP_LISTENS), ("tcp6", TCP_LISTENS), ("udp", UDP), ("udp6", UDP)):
        for line in Path(f"/proc/self/net/{table}").read_text().splitlines()[1:]:
            row = line.split()
            if row[3] == state and f"socket:[{row[9]}]" in own:
                address, _, port = row[1].partition(":")
                text = socket.inet_ntoa(bytes.fromhex(address)[::-1]) if len(address) == 8 else f"IPv6 {address}"
                found.append((text, int(port, 16)))
    return found


def attack(session: zenoh.Session, address: str, ports: list[int], seconds: float) -> None:
    """Say hello, unasked, to UDP ports of another machine, and scout for it."""
    datagrams = [hello(str(session.zid()), locator) for locator in own_locators()]
    until = time.monotonic() + seconds
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as line:
        line.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton(sys.argv[3]))
        while time.monotonic() < until:
            for datagram in (*datagrams, SCOUT):
                for port in ports:
                    line.sendto(datagram, (address, port))
                line.sendto(datagram, LocalBus().scouting_address)
            time.sleep(0.05)


def own_locators() -> list[str]:
    """Where this session can be connected to from elsewhere."""
    ports = {port for address, port in sockets() if address.startswith("IPv6")}
    return [f"tcp/{sys.argv[3]}:{port}" for port in ports]


def heard(seconds: float) -> list[str]:
    """The frames that come on the cable for a while, in hexadecimal, but for what the kernel sends by itself."""
    frames = []
    with socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(EVERYTHING)) as line:
        line.bind(("cable", 0))
        print(json.dumps("listening"), flush=True)
        until = time.monotonic() + seconds
        while (left := until - time.monotonic()) > 0:
            line.settimeout(left)
            try:
                frame, sender = line.recvfrom(2048)
            except TimeoutError:
                break  # the while for which it listens is over
            if sender[2] != socket.PACKET_OUTGOING and int.from_bytes(frame[12:14], "big") not in IGNORED:
                frames.append(frame.hex())
    return frames


def main() -> None:
    kind, name, _ = sys.argv[1:]
    with opened(kind) as session:

        def answer(query: zenoh.Query) -> None:
            with query:
                query.reply(f"{name}/here", name.encode())

        session.declare_queryable(f"{name}/here", answer)
        print(json.dumps("ready"), flush=True)
        for line in sys.stdin:
            given: dict[str, Any] = json.loads(line)
            match given:
                case {"do": "look"}:
                    replies = session.get("*/here", target=zenoh.QueryTarget.ALL, timeout=5.0)
                    print(json.dumps(sorted(str(reply.ok.key_expr) for reply in replies if reply.ok)), flush=True)
                case {"do": "sockets"}:
                    print(json.dumps(sockets()), flush=True)
                case {"do": "attack"}:
                    attack(session, given["address"], given["ports"], given["seconds"])
                    print(json.dumps("done"), flush=True)
                case {"do": "listen"}:
                    print(json.dumps(heard(given["seconds"])), flush=True)


if __name__ == "__main__":
    main()

"""Two sites on one machine: a network namespace each, and a cable between them that can be pulled."""

import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path

from tests.waiting import wait_until

ROOT = Path(__file__).resolve().parents[2]
ADDRESSES = ("10.77.0.1", "10.77.0.2")
CABLE = "cable"  # the network device at either end
ENDING_TIME = 5.0  # s


class NoNamespaces(RuntimeError):
    """This machine lets us make no network namespaces."""


class Site:
    """One site. It exists as long as a process that sleeps in it."""

    def __init__(self, holder: "subprocess.Popen[bytes]", owner: int, address: str) -> None:
        self.address = address
        self._enter = [
            "nsenter",
            f"--user=/proc/{owner}/ns/user",
            f"--net=/proc/{holder.pid}/ns/net",
            "--preserve-credentials",
        ]

    @contextmanager
    def program(self, *command: str) -> Iterator["subprocess.Popen[str]"]:
        """Run a module of ours there until the block ends: `program("acromovi", "router")`."""
        whole = [*self._enter, sys.executable, "-m", *command]
        with subprocess.Popen(
            whole, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=ROOT, start_new_session=True
        ) as process:
            try:
                yield process
            finally:
                _end(process)

    def tell(self, *command: str) -> str:
        """Run a tool there, to its end. Return what it prints."""
        return _run([*self._enter, *command])

    def has_cable(self) -> bool:
        """Whether programs there are told that the cable is in at both ends."""
        return " state UP " in self.tell("ip", "link", "show", CABLE)


@contextmanager
def two_sites() -> Iterator[tuple[Site, Site]]:
    """Two sites with a cable between them.

    Raises:
        NoNamespaces: They cannot be had here.
    """
    with ExitStack() as stack:
        first = stack.enter_context(_sleeper(["unshare", "--user", "--map-root-user", "--net"]))
        inside = ["nsenter", f"--user=/proc/{first.pid}/ns/user", "--preserve-credentials"]
        second = stack.enter_context(_sleeper([*inside, "unshare", "--net"]))
        sites = Site(first, first.pid, ADDRESSES[0]), Site(second, first.pid, ADDRESSES[1])
        sites[0].tell("ip", "link", "add", CABLE, "type", "veth", "peer", "name", CABLE, "netns", str(second.pid))
        for site in sites:
            site.tell("ip", "link", "set", "lo", "up")
            site.tell("ip", "address", "add", f"{site.address}/24", "dev", CABLE)
            site.tell("ip", "link", "set", CABLE, "up")
        for site in sites:
            # The kernel may take a second to say that the cable is in; a program that looks for others by multicast
            # and starts before never does so on this device.
            wait_until(site.has_cable, "the cable is in")
        yield sites


@contextmanager
def _sleeper(enter: Sequence[str]) -> Iterator["subprocess.Popen[bytes]"]:
    """A process that does nothing in a namespace of its own; it has arrived when it says so."""
    command = [*enter, "sh", "-c", "echo here; exec cat"]
    try:
        process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    except FileNotFoundError as error:
        raise NoNamespaces(f"{command[0]} is not installed") from error
    with process:
        assert process.stdout is not None
        assert process.stderr is not None
        if process.stdout.readline() != b"here\n":
            raise NoNamespaces(process.stderr.read().decode().strip())
        try:
            yield process
        finally:
            process.kill()


def _run(command: Sequence[str]) -> str:
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    except FileNotFoundError as error:
        raise NoNamespaces(f"{command[0]} is not installed") from error
    if done.returncode:
        raise NoNamespaces(f"{' '.join(command)}: {done.stderr.strip()}")
    return done.stdout


def _end(process: "subprocess.Popen[str]") -> None:
    process.terminate()
    try:
        process.wait(ENDING_TIME)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()

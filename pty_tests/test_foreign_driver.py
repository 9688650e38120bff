"""A driver written elsewhere meets the robot: Soar's ARCOS client, used as a library.

It opens the port anew at each rate it tries, sends CLOSE before the handshake, and shares no code with us.
"""

import threading
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from pty_tests.client import Client
from pty_tests.conftest import Site
from pty_tests.firmware import ARCOS, Firmware
from pty_tests.models import Model

pytestmark = [
    pytest.mark.moves,
    # In the office there are echoes nearer than 5 m; without any, Soar waits 5 s for one at every connection.
    pytest.mark.emulate("p3dx-sh@office"),
    # Soar's threads may be caught between their last look at the flag and the closed port, and die of it.
    pytest.mark.filterwarnings("ignore::pytest.PytestUnhandledThreadExceptionWarning"),
]


@pytest.fixture
def arcos() -> Any:
    """Soar's module; imported for its tests only, since it brings a window system with it."""
    return pytest.importorskip(
        "soar.robot.arcos", reason="Soar imports tkinter, which this Python lacks", exc_type=ImportError
    )


@pytest.fixture
def connect(site: Site, firmware: Firmware, arcos: Any) -> Iterator[Callable[[], Any]]:
    """A function that returns a new, connected Soar client."""
    if firmware.family != ARCOS:
        pytest.skip("Soar reads the fields that only ARCOS sends")
    if "://" in site.port:
        pytest.skip("Soar opens devices only")
    clients = []
    others = set(threading.enumerate())

    def new_client() -> Any:
        client = arcos.ARCOSClient()
        clients.append(client)
        client.connect(forced_ports=[site.port])
        return client

    yield new_client
    for client in clients:
        if client.ser is not None and client.ser.is_open:
            client.disconnect()
    for thread in set(threading.enumerate()) - others:
        thread.join(5.0)  # its pulse sleeps for a second; what it dies of afterwards would be another test's warning
    with Client(site.port, site.baud) as ours:
        ours.hang_up()


def until(client: Any, holds: Callable[[dict[str, Any]], object], tries: int = 40) -> dict[str, Any]:
    """The first of the next standard SIPs, as Soar decodes them, that fits."""
    for _ in range(tries):
        client.wait_or_timeout(client.standard_event, 2.0, "no SIP")
        if holds(client.standard):
            return dict(client.standard)
    raise AssertionError(f"not within {tries} SIPs: {client.standard}")


def ask(client: Any, event: threading.Event, command: int, argument: int | None = None) -> None:
    event.clear()
    client.send_command(command, argument)
    client.wait_or_timeout(event, 2.0, f"no answer to {command}")


def is_free(site: Site) -> bool:
    """Whether the robot heard that the last client left, and waits for the next one.

    Soar flushes the port when it comes. Unlike a serial port a pseudo-terminal does not wait at the close for what is
    still under way, so that flush may take the CLOSE of the client before with it, where the machine is busy.
    """
    with Client(site.port, site.baud) as ours:
        return any(ours.greets(0.4) for _ in range(10))


def test_soar_connects_reads_everything_drives_and_leaves_several_times(
    connect: Callable[[], Any], arcos: Any, site: Site, model: Model
) -> None:
    for _ in range(3):
        client = connect()
        ask(client, client.config_event, arcos.CONFIG)
        assert client.config["ROBOT_TYPE"] == "Pioneer"
        assert client.config["SUBTYPE"] == model.subtype
        assert client.config["TRANSVELMAX"] > 0

        ask(client, client.io_event, arcos.IOREQUEST, 1)
        assert (client.io["N DIGIN"], client.io["N_DIGOUT"]) == (4, 1), "ARCOS groups, as Soar takes them for granted"
        assert len(client.io["ANALOGS"]) == client.io["N_AN"]

        assert set(until(client, lambda sip: sip["SONARS"])["SONARS"]) <= model.discs

        ask(client, client.encoder_event, arcos.ENCODER, 1)
        before = client.encoder["L_ENCODER"]
        client.send_command(arcos.ENABLE, 1)
        client.send_command(arcos.VEL, 200)
        until(client, lambda sip: sip["L VEL"] > 190 and sip["R VEL"] > 190)
        client.send_command(arcos.STOP)
        until(client, lambda sip: sip["L VEL"] == sip["R VEL"] == 0)
        ask(client, client.encoder_event, arcos.ENCODER, 1)
        assert client.encoder["L_ENCODER"] != before
        client.disconnect()
        assert is_free(site)

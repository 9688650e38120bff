"""Radio modems: dialling, the one rate they know, and ends that send in turn."""

from typing import Any

import configs
from p2os_emu.links.line import EmulatedLine, LinkProfile
from p2os_emu.links.memory import MemoryLink
from p2os_emu.links.modem import Dialling, Modem, Slot
from p2os_emu.links.stage import Rates

STEP = 1 / 120
SYNC0 = bytes.fromhex("FA FB 03 00 00 00")
DIAL = b"WMS2\r"  # source: protocol sheet, what client libraries write before SYNC0
RADIO = configs.load(LinkProfile, "links", "radio-modem")
assert RADIO.modem is not None
MODEM = RADIO.modem
SHY = Modem(MODEM.baud, MODEM.dial_string, MODEM.connecting, MODEM.connected, dial_time=0.1, auto_connect=False)


def reach(
    line: EmulatedLine, link: MemoryLink, data: bytes, start: float = 0.0, seconds: float = 1.0, baud: int = 9600
) -> bytes:
    """Write as a client; what has reached the robot after a while."""
    link.client_write(data)
    heard = b""
    for step in range(round(seconds / STEP)):
        heard += line.receive(start + step * STEP, baud)
        line.send(b"", start + step * STEP, baud)
    return heard


def quiet(**changes: Any) -> LinkProfile:
    """The radio modem on a day without noise."""
    return LinkProfile("quiet", enforces_baud=True, paces=True, modem=MODEM, **changes)


def test_client_that_never_dials_is_heard() -> None:
    link = MemoryLink(client_rate=9600)
    assert reach(EmulatedLine(link, quiet()), link, SYNC0) == SYNC0


def test_dial_string_is_kept_from_the_robot_and_answered() -> None:
    link = MemoryLink(client_rate=9600)
    assert reach(EmulatedLine(link, quiet()), link, DIAL + SYNC0) == SYNC0
    answer = link.client_read()
    assert answer.startswith(DIAL)
    assert b"Connected to address" in answer, "what clients that dial look for"


def test_dial_string_is_found_however_it_is_cut() -> None:
    dialling = Dialling(SHY)
    assert b"".join(dialling.hear(bytes([byte]), 0.0) for byte in b"WW" + DIAL) == b""
    dialling.say(b"", 0.2)
    assert dialling.is_connected


def test_beginning_of_a_dial_string_that_ends_otherwise_is_passed_on() -> None:
    dialling = Dialling(MODEM)
    assert dialling.hear(b"WM", 0.0) + dialling.hear(b"X", 0.0) == b"WMX"


def test_modem_that_waits_to_be_dialled_lets_nothing_through_before() -> None:
    link = MemoryLink(client_rate=9600)
    line = EmulatedLine(link, LinkProfile("shy", modem=SHY))
    assert reach(line, link, SYNC0) == b""
    line.send(SYNC0, 1.0, 9600)
    assert link.client_read() == b""
    assert reach(line, link, DIAL, 1.0) == b""
    assert reach(line, link, SYNC0, 2.0) == SYNC0


def test_modem_connects_only_after_the_time_it_takes() -> None:
    dialling = Dialling(SHY)
    dialling.hear(DIAL, 1.0)
    assert dialling.say(b"sip", 1.05) == DIAL + MODEM.connecting.encode()
    assert dialling.say(b"sip", 1.1) == MODEM.connected.encode() + b"sip"


def test_robot_that_changes_its_rate_is_lost_to_the_modem() -> None:
    link = MemoryLink(client_rate=38400)
    line = EmulatedLine(link, quiet())
    assert reach(line, link, SYNC0, baud=38400) != SYNC0
    link.client_rate = 9600
    assert reach(line, link, SYNC0, 1.0) == SYNC0


def test_modem_sends_at_its_own_rate() -> None:
    link = MemoryLink(client_rate=None)
    line = EmulatedLine(link, LinkProfile("slow", paces=True, modem=MODEM))
    line.send(SYNC0 * 100, 0.0, 115200)
    line.send(b"", 0.25, 115200)
    assert len(link.client_read()) == 240


def test_ends_that_send_in_turn_never_send_together() -> None:
    up, down = Slot(0.02, 0), Slot(0.02, 1)
    rates = Rates(9600, 9600)
    sent = [(up.carry(b"u", step * STEP, rates), down.carry(b"d", step * STEP, rates)) for step in range(120)]
    assert not any(host and robot for host, robot in sent)
    assert sum(len(host) for host, _ in sent) >= 115
    assert sum(len(robot) for _, robot in sent) >= 115


def test_accessories_have_cables_of_their_own_beside_the_radio() -> None:
    cable = RADIO.of_accessories
    assert cable.modem is None
    assert cable.to_host == cable.to_robot == LinkProfile("").to_host
    assert cable.paces


def test_radio_is_late_and_loses_bytes_now_and_then_the_same_for_the_same_seed() -> None:
    def heard(seed: int) -> bytes:
        link = MemoryLink(client_rate=9600)
        line = EmulatedLine(link, RADIO, seed)
        sip = b"\xfa\xfb\x50" + b"s" * 80
        for step in range(20000):
            line.send(sip if step % 12 == 0 else b"", step * STEP, 9600)
        return link.client_read()

    sent = 20000 // 12 * 83
    assert 0.98 * sent < len(heard(1)) < sent
    assert heard(1) == heard(1)
    assert heard(1) != heard(2)

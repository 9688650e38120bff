"""The compliance page: parts of the protocol that are decoded, encoded, emulated and tested, by the packet tables."""

from collections.abc import Collection, Iterable, Iterator, Sequence
from typing import NamedTuple

from p2os.command_table import COMMANDS
from p2os.configuration import CONFIGURATION_VARIANTS
from p2os.fields import Field, Quantity
from p2os.firmware import FIRMWARES
from p2os.packets import LAYOUTS, MTX_TYPES, TABLES, PacketType
from p2os.sip import COUNT, HEAD, SONAR, TAIL

INTRODUCTION = """\
# Protocol

What of the ActivMedia wire protocol (P2OS, AROS, ARCOS) this project speaks. This page is printed from the tables that
encoder and decoder use (`make docs`), and a test compares the two. *Decoded* and *encoded* are what `p2os` reads and
writes, *emulated* is what the microcontroller of `p2os-emu` sends or acts on; a dash means no. What is *as simulator*
exists only with `p2os-emu --as-simulator`; without the option these commands are unknown, as on a real robot.

Sources: P2 manual, Pioneer 2 and PeopleBot operations manual (P2OS); H8 manual, Pioneer 3 and 2 H8-series manual
(AROS); P3 manual, Pioneer 3 operations manual (ARCOS); accessory manuals; client library, what ARIA and Player read and
send.

A frame is `FA FB`, a count of the bytes that follow, the payload, and a checksum, most significant byte first. Other
numbers are little-endian. Quantities are in SI and radians everywhere above the wire.
"""

SOURCES = {
    **dict.fromkeys((*TABLES, *MTX_TYPES), "client library"),
    PacketType.SYNC0: "P3 manual",
    PacketType.SYNC1: "P3 manual",
    PacketType.SYNC2: "P3 manual",
    PacketType.CONFIGURATION: "H8 manual, client library",
    PacketType.SIP_STOPPED: "P3 manual, client library",
    PacketType.SIP_MOVING: "P3 manual, client library",
    PacketType.ENCODERS: "P3 manual",
    PacketType.AUX1: "P2 and P3 manuals",
    PacketType.AUX2: "P3 manual",
    PacketType.AUX3: "P3 manual",
    PacketType.COMPASS: "compass manual",
    PacketType.ARM: "arm manual",
    PacketType.ARM_INFO: "arm manual",
    PacketType.PLAYLIST: "Amigo manual",
    PacketType.GRIPPER: "gripper manual",
    PacketType.INPUTS_OUTPUTS: "P3 manual, client library",
    PacketType.JOYSTICK: "Pioneer LX guide, client library",
}
"""Where a packet is described."""

ACCESSORY_TEST = "tests/p2os/test_accessory_packets.py"
TESTS = {
    **dict.fromkeys(TABLES, ACCESSORY_TEST),
    **dict.fromkeys(MTX_TYPES, ACCESSORY_TEST),
    PacketType.SYNC0: "tests/p2os/test_handshake.py",
    PacketType.SYNC1: "tests/p2os/test_handshake.py",
    PacketType.SYNC2: "tests/p2os/test_handshake.py",
    PacketType.CONFIGURATION: "tests/p2os/test_packets.py",
    PacketType.SIP_STOPPED: "tests/p2os/test_sip.py",
    PacketType.SIP_MOVING: "tests/p2os/test_sip.py",
    PacketType.ENCODERS: "tests/p2os/test_packets.py",
    PacketType.INPUTS_OUTPUTS: "tests/p2os/test_packets.py",
}
COMMAND_TEST = "tests/p2os/test_commands.py"
HANDSHAKE = (PacketType.SYNC0, PacketType.SYNC1, PacketType.SYNC2)

_CODES = {
    "b": "i8",
    "B": "u8",
    "h": "i16",
    "H": "u16",
    "i": "i32",
    "I": "u32",
    "z": "text, NUL",
    "s": "bytes",
}


_PRINTED = (
    *((f"{layout.name} (0x{kind:02X})", layout.fields) for kind, layout in sorted(LAYOUTS.items())),
    ("SIMSTAT packet (0x62)", TABLES[PacketType.SIMULATOR_STATE]),
    ("SERAUXpacs (0xB0, 0xB8, 0xC8)", TABLES[PacketType.AUX1]),
    ("Reset (0xFE, 0xFF)", TABLES[PacketType.RESET]),
)


class Emulated(NamedTuple):
    """Commands and packets of the emulator.

    commands: numbers of those that it acts on. packets: types of those that it sends.
    simulator_commands, simulator_packets: those of them that exist only when it is started as a simulator.
    """

    commands: Collection[int]
    packets: Collection[int]
    simulator_commands: Collection[int] = ()
    simulator_packets: Collection[int] = ()

    def page(self) -> str:
        """Return the compliance page."""
        sections = [
            INTRODUCTION,
            "## Packets from the robot\n",
            _packets(self),
            "## Standard SIP (0x32, 0x33)\n",
            _fields((*HEAD, COUNT)),
            "Then, for each reading:\n",
            _fields(SONAR),
            "Then, as far as the packet goes; a decoder accepts an end after any field:\n",
            _fields(TAIL),
            *(section for title, fields in _PRINTED for section in (f"## {title}\n", _fields(fields))),
            "## Where packets end\n",
            _ends(),
            "## Commands to the robot\n",
            _commands(self),
        ]
        return "\n".join(sections)


def _packets(emulated: Emulated) -> str:
    rows = []
    for kind in PacketType:
        known = "handed on" if kind in MTX_TYPES else _yes(kind in TABLES or kind in HANDSHAKE)
        rows.append(
            (
                f"0x{kind:02X} {kind.name.replace('_', ' ')}",
                known,
                known,
                _emulated(kind, emulated.packets, emulated.simulator_packets),
                SOURCES.get(kind, "client library"),
                TESTS.get(kind, "-"),
            )
        )
    return _table(("packet", "decoded", "encoded", "emulated", "source", "test"), rows)


def _commands(emulated: Emulated) -> str:
    rows = [
        (
            f"{command.value} {command.name}",
            command.argument.value,
            command.quantity.unit or "-",
            command.meaning,
            str(command.since),
            "yes",
            "yes",
            _emulated(command.value, emulated.commands, emulated.simulator_commands),
            command.source,
            COMMAND_TEST,
        )
        for command in COMMANDS.values()
    ]
    columns = ("command", "argument", "unit", "meaning", "since", "decoded", "encoded", "emulated", "source", "test")
    return _table(columns, rows)


def _fields(fields: Sequence[Field]) -> str:
    rows = [
        (name, _on_the_wire(field.code), _quantity(field.quantity), field.meaning or "-")
        for name, field in _flat(fields, "")
    ]
    return _table(("field", "on the wire", "above the wire", "notes"), rows)


def _flat(fields: Sequence[Field], prefix: str) -> Iterator[tuple[str, Field]]:
    """The fields of a table by name, those of records behind the field that holds them."""
    for field in fields:
        yield prefix + field.name, field
        yield from _flat(field.items, f"{field.name}: ")


def _on_the_wire(code: str) -> str:
    """A field's code in words."""
    item = code.lstrip("*+0123456789")
    kind = _CODES.get(item, "record")
    if code.startswith("**"):
        return f"rows u8, columns u8, {kind} each"
    if code.startswith("*"):
        return f"count u8, {kind}" + ("" if item == "s" else " each")
    if code.startswith("+"):
        return f"{kind} to the end"
    if item == "s":
        return f"text, {code[:-1]} bytes"
    return f"{code[:-1]} of {kind}" if len(code) > 1 else kind


def _ends() -> str:
    families = [
        (firmware.family.value, firmware.last_sip_field, firmware.last_configuration_field)
        for firmware in FIRMWARES.values()
    ]
    variants = [(firmware, "-", last) for firmware, last in CONFIGURATION_VARIANTS.items()]
    return _table(("firmware", "last field of a SIP", "last field of a CONFIGpac"), families + variants)


def _quantity(quantity: Quantity) -> str:
    return f"{quantity.label}, {quantity.unit}" if quantity.unit else quantity.label


def _emulated(number: int, always: Collection[int], as_simulator: Collection[int]) -> str:
    return "as simulator" if number in as_simulator else _yes(number in always)


def _yes(claim: bool) -> str:
    return "yes" if claim else "-"


def _table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [header, ["---"] * len(header), *rows]
    return "".join(f"| {' | '.join(cells)} |\n" for cells in lines)

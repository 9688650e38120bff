"""Facts of the wire stand in `p2os` and nowhere else: emulator and gateway import them.

The rules look at the source of both programs. What they find is moved to `p2os` or listed in `ALLOWED` with a reason.
"""

import ast
import re
import tokenize
from collections.abc import Iterator, Mapping, Sequence
from enum import Enum
from importlib import import_module
from io import StringIO
from typing import NamedTuple

import pytest

from p2os import Command, PacketType
from tools.structure import modules

PROGRAMS = ("p2os_emu", "gateway")
BIT_OPERATIONS = ast.BitAnd | ast.BitOr | ast.BitXor | ast.LShift | ast.RShift
BYTE_CONVERSIONS = {"to_bytes", "from_bytes", "fromhex"}
WIRE_NAMES = {"payload", "frame", "telegram", "argument", "mask", "levels", "packet_type", "bumpers", "drift"}
"""Variables that hold bytes or counts of the wire."""
PREFIX = re.compile("0[xXbB]")
"""Of a number that is not decimal; it is found in texts too."""
SMALL = (-1, 0, 1)
"""Numbers that are no facts by themselves: signs, off and on."""


class Finding(NamedTuple):
    """A constant of the wire. text: its source."""

    rule: str
    text: str


ALLOWED: Mapping[tuple[str, Finding], str] = {
    ("p2os_emu.camera.news", Finding("bytes", r"b'\x00'")): "between two processes of the emulator",
    ("p2os_emu.camera.news", Finding("bytes", r"b'\x01'")): "between two processes of the emulator",
    ("p2os_emu.camera.server", Finding("bytes", r"b'\r\n'")): "HTTP",
    ("p2os_emu.recording", Finding("byte order", "bytes.fromhex(entry['hex'])")): "the file format of a recording",
    ("p2os_emu.control", Finding("bytes", r"b'\n'")): "lines of JSON",
    ("p2os_emu.links.modem", Finding("bytes", r"b'\r'")): "ends the dial string of a modem",
    ("p2os_emu.world.collision", Finding("numbered names", "Group")): "collision groups of the physics engine",
    ("gateway.bridge", Finding("bytes", "b'!'")): "wakes the bridge's own thread",
    ("gateway.errors", Finding("numbered names", "ExitCode")): "exit codes of the program",
    ("gateway.line", Finding("bytes", "b'onnected to address'")): "what a radio modem says",
    ("gateway.line", Finding("bytes", r"b'WMS2\r'")): "what a radio modem is told",
}
SHARED: Mapping[str, str] = {
    "PATIENCE": "times to wait for different things",
    "ENDING_TIMEOUT_S": "time that a child process has to end",
    "EXIT_OK": "exit code of every program",
    "EXIT_USAGE": "exit code of every program",
}
"""Names that both programs define with one value, and why that is no fact of the wire."""


def facts() -> Mapping[str, object]:
    """Constants of `p2os` at module level, by name, and the names of its enumerations."""
    found: dict[str, object] = {}
    for module in modules(packages=("p2os",)):
        for name, value in vars(import_module(module)).items():
            if name.isupper() or (isinstance(value, type) and issubclass(value, Enum)):
                found[name] = value
    return found


FACTS = facts()


def _number(node: ast.AST) -> int | float | None:
    match node:
        case ast.Constant(value=bool()):
            return None
        case ast.Constant(value=int() | float() as value):
            return value
        case ast.UnaryOp(op=ast.USub(), operand=ast.Constant(value=int() | float() as value)):
            return -value
    return None


def _is_magic(node: ast.AST) -> bool:
    return (value := _number(node)) is not None and value not in SMALL


def _is_member(node: ast.AST) -> bool:
    """Whether it is a member of an enumeration of `p2os`, such as `Command.VEL`."""
    match node:
        case ast.Attribute(value=ast.Name(id=name) | ast.Attribute(attr=name)):
            return isinstance(FACTS.get(name), type)
    return False


def _literal(node: ast.AST) -> object:
    """The value of a constant expression; None where it is none."""
    match node:
        case ast.Call(func=ast.Name(id="range"), args=arguments):
            bounds = [_literal(argument) for argument in arguments]
            return range(*(each for each in bounds if isinstance(each, int))) if None not in bounds else None
    try:
        return ast.literal_eval(node)
    except ValueError:  # no literal
        return None


def _bytes(node: ast.AST) -> Iterator[Finding]:
    match node:
        case ast.Constant(value=bytes() as value) if value:
            yield Finding("bytes", ast.unparse(node))
        case ast.Call(func=ast.Attribute(attr=name)) if name in BYTE_CONVERSIONS:
            yield Finding("byte order", ast.unparse(node))
        case ast.Call(func=ast.Name(id="bytes"), args=[ast.List(elts=items) | ast.Tuple(elts=items)]):
            if any(_number(item) is not None for item in items):
                yield Finding("bytes", ast.unparse(node))
        case ast.Import(names=[ast.alias(name="struct")]) | ast.ImportFrom(module="struct"):
            yield Finding("struct", ast.unparse(node))


def _bits(node: ast.AST) -> Iterator[Finding]:
    """Masks and shifts by a number; `1 << n` and `& 1` are how any bit is set and read."""
    match node:
        case ast.BinOp(left=left, op=op, right=right) if isinstance(op, BIT_OPERATIONS):
            one_bit = isinstance(op, ast.LShift) and _number(left) == 1 and _number(right) is None
            last_bit = isinstance(op, ast.BitAnd) and _number(right) == 1
            if not one_bit and not last_bit and (_number(left) is not None or _number(right) is not None):
                yield Finding("bits", ast.unparse(node))


def _comparisons(node: ast.AST) -> Iterator[Finding]:
    """Numbers beside members of wire enumerations, and beside variables that hold what the wire carries."""
    match node:
        case ast.Compare(left=left, comparators=rights):
            sides = [left, *rights]
            about = {inner.id for side in sides for inner in ast.walk(side) if isinstance(inner, ast.Name)}
            if any(map(_is_magic, sides)) and (about & WIRE_NAMES or any(map(_is_member, sides))):
                yield Finding("comparison", ast.unparse(node))
        case ast.Call(args=arguments) if any(map(_is_member, arguments)) and any(map(_is_magic, arguments)):
            yield Finding("argument", ast.unparse(node))
        case ast.Tuple(elts=[first, second]) if _is_member(first) and _is_magic(second):
            yield Finding("argument", ast.unparse(node))
        case ast.Call(func=ast.Name(id="encode_command" | "Command" | "PacketType"), args=[number, *_]):
            if _number(number) is not None:
                yield Finding("argument", ast.unparse(node))


def _numbered_names(node: ast.AST) -> Iterator[Finding]:
    """Enumerations, names for 0, 1, 2 and so on, and tables by number."""
    match node:
        case ast.ClassDef(bases=bases):
            if any(isinstance(base, ast.Name) and base.id in ("IntEnum", "IntFlag") for base in bases):
                yield Finding("numbered names", node.name)
        case ast.Assign(targets=[ast.Tuple()], value=ast.Tuple(elts=items)):
            numbers = [_number(item) for item in items]
            if numbers[0] in (0, 1, 2) and numbers == [numbers[0] + i for i in range(len(items))]:
                yield Finding("numbered names", ast.unparse(node))
        case ast.Assign(targets=[ast.Tuple()], value=ast.Call(func=ast.Name(id="range"))):
            yield Finding("numbered names", ast.unparse(node))
        case ast.Assign(value=ast.Dict(keys=keys)) | ast.AnnAssign(value=ast.Dict(keys=keys)):
            if any(key is not None and _number(key) is not None for key in keys):
                yield Finding("table by number", ast.unparse(node))


def _repeated_facts(node: ast.AST) -> Iterator[Finding]:
    """Constants with the name and the value of a fact."""
    match node:
        case ast.Assign(targets=[ast.Name(id=name)], value=value):
            given = _literal(value)
            if given is not None and name in FACTS and FACTS[name] == given:
                yield Finding("repeated fact", ast.unparse(node))


def _names(module: ast.Module, nodes: Sequence[ast.AST]) -> Iterator[Finding]:
    ignored = {id(node.value) for node in nodes if isinstance(node, ast.Expr)}
    for node in module.body:
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__":
            ignored |= {id(inner) for inner in ast.walk(node)}
    known = Command.__members__.keys() | PacketType.__members__.keys()
    for inner in nodes:
        if isinstance(inner, ast.Constant) and id(inner) not in ignored and inner.value in known:
            yield Finding("name of a command or packet", ast.unparse(inner))


def _hexadecimal(text: str) -> Iterator[Finding]:
    if not PREFIX.search(text):  # tokens take long
        return
    for token in tokenize.generate_tokens(StringIO(text).readline):
        if token.type == tokenize.NUMBER and token.string[:2].lower() in ("0x", "0b"):
            yield Finding("hexadecimal", token.string)


def findings(text: str) -> set[Finding]:
    """What the rules find in a module's source."""
    module = ast.parse(text)
    knows_wire = any(
        isinstance(node, ast.ImportFrom) and (node.module or "").partition(".")[0] == "p2os" for node in module.body
    )
    nodes = list(ast.walk(module))
    found = {*_names(module, nodes), *_hexadecimal(text)}
    for node in module.body:
        found.update(_repeated_facts(node))
        if knows_wire or isinstance(node, ast.ClassDef):
            found.update(_numbered_names(node))
    for inner in nodes:
        found.update((*_bytes(inner), *_bits(inner), *_comparisons(inner)))
    return found


@pytest.fixture(scope="module")
def found() -> set[tuple[str, Finding]]:
    known = modules(packages=PROGRAMS)
    return {(name, finding) for name, module in known.items() for finding in findings(module.text)}


def test_emulator_and_gateway_have_no_wire_constants_of_their_own(found: set[tuple[str, Finding]]) -> None:
    assert sorted(found - ALLOWED.keys()) == []


def test_every_exception_is_needed(found: set[tuple[str, Finding]]) -> None:
    assert sorted(ALLOWED.keys() - found) == []


def test_emulator_and_gateway_do_not_define_a_constant_each() -> None:
    values: dict[tuple[str, str], set[str]] = {}
    for name, module in modules(packages=PROGRAMS).items():
        for node in module.tree.body:
            match node:
                case ast.Assign(targets=[ast.Name(id=constant)], value=value) if _literal(value) is not None:
                    values.setdefault((constant, ast.unparse(value)), set()).add(name.partition(".")[0])
    assert {constant for (constant, _), programs in values.items() if len(programs) > 1} <= SHARED.keys()


@pytest.mark.parametrize(
    ("planted", "rule"),
    [
        (r'SYNC = b"\xfa\xfb"', "bytes"),
        ("frame = bytes([14, argument])", "bytes"),
        ("count = int.from_bytes(data[:2], 'little')", "byte order"),
        ("import struct", "struct"),
        ("from struct import Struct", "struct"),
        ("has_stalled = flags & 256", "bits"),
        ("state = paddles | lift << 4", "bits"),
        ("MOTORS = 1 << 4", "bits"),
        ("class Order(IntEnum):\n    OPEN = 1", "numbered names"),
        ("from p2os import Command\nONE, CONTINUOUS = 1, 2", "numbered names"),
        ("from p2os import Command\nOFF, PLAIN, EXTENDED = range(3)", "numbered names"),
        ("from p2os import Command\nCHARGERS = {1: 'Pioneer 3', 2: 'PowerBot'}", "table by number"),
        ("is_whole = len(payload) > 3", "comparison"),
        ("is_valid = 0 <= bumpers <= 3", "comparison"),
        ("is_laser = Command.SIM_LRF_ENABLE == 230", "comparison"),
        ("ask(Command.TCM2, 2)", "argument"),
        ("question = Command.ARM_STATUS, 2", "argument"),
        ("encode_command(11)", "argument"),
        ("PULSE_UNIT = 1e-5", "repeated fact"),
        ("SERVO_PORTS = range(1, 5)", "repeated fact"),
        ("name = 'SETRVDIR'", "name of a command or packet"),
        ("INPUTS = 0xFF", "hexadecimal"),
    ],
)
def test_a_planted_constant_is_found(planted: str, rule: str) -> None:
    assert rule in {finding.rule for finding in findings(planted)}


@pytest.mark.parametrize(
    "harmless",
    [
        '"""Answers SYNC2 with 0x02."""',
        "from p2os import Command\nask(Command.ENABLE, 1)",
        "pressed = bumpers >> segment & 1",
        "mask = 1 << number",
        "STEP = 1 / 120",
        "is_late = delay > 0.5",
    ],
)
def test_ordinary_code_is_not_taken_for_a_constant_of_the_wire(harmless: str) -> None:
    assert findings(harmless) == set()

"""A process that calls the functions of a C library for an agent: `python -m agents.wrappers.library_process FILE`.

It is a process of its own because a fault in C ends the process. It reads calls from its standard input, writes answers
to its standard output (`frames`), and ends with its input.
"""

import ctypes
import os
import sys
from collections.abc import Callable, Mapping
from math import isfinite, prod
from pathlib import Path
from typing import Any

from agents.wrappers.frames import LARGEST, FrameSplitter, answer
from agents.wrappers.wrapper_file import FunctionArgument, FunctionRow, WrapperFile

NUMBERS: dict[str, Any] = {
    "int8": ctypes.c_int8,
    "int16": ctypes.c_int16,
    "int32": ctypes.c_int32,
    "int64": ctypes.c_int64,
    "uint8": ctypes.c_uint8,
    "uint16": ctypes.c_uint16,
    "uint32": ctypes.c_uint32,
    "uint64": ctypes.c_uint64,
    "float": ctypes.c_float,
    "double": ctypes.c_double,
}
TYPES = {**NUMBERS, "text": ctypes.c_char_p, "bytes": ctypes.c_char_p, "out": ctypes.c_void_p, "void": None}
PORTION = 1 << 20


def _library_path(file: str, beside: Path) -> str:
    """Return the path of a library: a path with a slash is relative to the wrapper's file."""
    return str(beside.parent / file) if "/" in file else file


class _CFunction:
    """One function by its row.

    Raises:
        ValueError: The library has no such function, or the row does not describe it; the message says why.
    """

    def __init__(self, library: ctypes.CDLL, row: FunctionRow) -> None:
        self._row = row
        symbol = row.symbol or row.name
        try:
            self._function = getattr(library, symbol)
        except AttributeError as error:
            raise ValueError(f"the library has no function {symbol!r}") from error
        self._function.argtypes = [_type(argument.kind) for argument in row.arguments]
        self._function.restype = _type(row.returns)

    def call(self, given: Mapping[str, Any]) -> dict[str, Any]:
        """Call it; its return value comes as `value`, what it wrote under the names of the `out` arguments.

        Raises:
            ValueError: An argument does not fit, or the function says that it failed.
        """
        given = {**self._row.defaults, **given}
        written = {
            argument.name: ctypes.create_string_buffer(_size(argument, given))
            for argument in self._row.arguments
            if argument.kind == "out"
        }
        value = self._function(*(_as_c(each, {**given, **written}) for each in self._row.arguments))
        if self._row.fails_below is not None and value < self._row.fails_below:
            raise ValueError(f"{self._row.why} ({value})")
        returned = {} if self._row.returns == "void" else {"value": _as_json(value)}
        return {**returned, **{name: buffer.raw for name, buffer in written.items()}}


def _type(kind: str) -> Any:
    if kind not in TYPES:
        raise ValueError(f"there is no C type {kind!r} here; choose one of {', '.join(TYPES)}")
    return TYPES[kind]


def _as_c(argument: FunctionArgument, given: Mapping[str, Any]) -> Any:
    value = given.get(argument.name)
    if argument.kind == "out":
        return value
    if isinstance(value, str) and argument.kind == "text":
        return value.encode()
    if isinstance(value, bytes) and argument.kind == "bytes":
        return value
    if argument.kind in ("float", "double") and isinstance(value, int | float) and not isinstance(value, bool):
        return float(value)
    if argument.kind in NUMBERS and isinstance(value, int):
        if NUMBERS[argument.kind](value).value != value:
            raise ValueError(f"{argument.name} of {value} does not fit {argument.kind}")
        return value
    raise ValueError(f"{argument.name} must be {argument.kind}, not {type(value).__name__}")


def _as_json(value: Any) -> Any:
    if isinstance(value, bytes):
        return value.decode("utf-8", "replace")
    return None if isinstance(value, float) and not isfinite(value) else value


def _size(argument: FunctionArgument, given: Mapping[str, Any]) -> int:
    """Of an `out` argument, bytes: a product of numbers, of arguments, or as many as an argument has bytes."""
    factors = []
    for word in argument.size.split("*"):
        value: Any = int(word) if word.strip().isdecimal() else given.get(word.strip())
        factors.append(len(value) if isinstance(value, bytes) else value)
    if not all(isinstance(factor, int) and factor >= 0 for factor in factors):
        raise ValueError(f"the size {argument.size!r} of {argument.name} cannot be told from the arguments")
    size = prod(factors)
    if size > LARGEST:
        raise ValueError(f"{argument.name} of {size} bytes is too large")
    return size


def _functions_of(file: str) -> dict[str, Callable[[Mapping[str, Any]], dict[str, Any]]]:
    """Load the library of a wrapper's file.

    Raises:
        ConfigError: The file has an error.
        ValueError, OSError: The library cannot be used.
    """
    wrapper, path = WrapperFile.load(file)
    if wrapper.library is None:
        raise ValueError(f"{file} has no [library]")
    library = ctypes.CDLL(_library_path(wrapper.library.file, path))
    return {row.name: _CFunction(library, row).call for row in wrapper.functions}


def main(file: str) -> int:
    """Answer calls until the input ends."""
    calls, answers = sys.stdin.fileno(), os.dup(sys.stdout.fileno())
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # output of the library must not mix with the answers
    try:
        functions = _functions_of(file)
    except (ValueError, OSError) as err:
        print(err, file=sys.stderr)
        return 1
    splitter = FrameSplitter()
    while data := os.read(calls, PORTION):
        for head, blobs in splitter.receive(data):
            try:
                said = answer(functions[head["function"]]({**head["arguments"], **blobs}))
            except ValueError as err:
                said = answer(str(err))
            _write(answers, said)
    return 0


def _write(descriptor: int, data: bytes) -> None:
    view = memoryview(data)
    while view:
        view = view[os.write(descriptor, view) :]


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))

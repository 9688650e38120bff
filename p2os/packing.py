"""From SI values to the bytes of a packet and back, field by field; the two are mirrors, so that no end drifts."""

import struct
from collections.abc import Sequence
from typing import Any, NamedTuple

from p2os.errors import EncodeError
from p2os.fields import Field, Quantity, Scales

STRING = "z"
COUNTED = "*"
ROWS = "**"
TO_THE_END = "+"
BYTES = "s"
MOST = 255
"""What a count byte counts to."""

Value = float | str | bytes | tuple[Any, ...]


class _Unpacked(NamedTuple):
    """The values of a packet.

    values: SI, one per field. is_whole: no field was cut short; bytes behind the last one do no harm.
    """

    values: list[Value]
    is_whole: bool


def pack(fields: Sequence[Field], values: Sequence[Value], scales: Scales) -> bytes:
    """Turn SI values into the bytes of a packet.

    Raises:
        EncodeError: A value does not fit its field.
    """
    return b"".join(_pack_field(field, value, scales) for field, value in zip(fields, values, strict=True))


def unpack(fields: Sequence[Field], body: bytes, scales: Scales) -> _Unpacked:
    """Turn the bytes of a packet into SI values, one per field.

    Fields that the body ends before read as zero or empty, bytes after the last field are ignored: firmware has grown
    its packets at the end, and clients have always read them so.
    """
    reader = _Reader(body, scales)
    values = [reader.field(field) for field in fields]
    return _Unpacked(values, reader.offset <= len(body))


def _pack_field(field: Field, value: Any, scales: Scales) -> bytes:
    code = field.code
    if code == STRING:
        return _text(value) + b"\0"
    if code.startswith(ROWS):
        return _pack_rows(field, value, scales)
    if code.startswith((COUNTED, TO_THE_END)):
        return _pack_list(field, value, scales)
    if code.endswith(BYTES):
        return struct.pack(code, _text(value))
    if len(code) > 1:
        return _pack_items(_item(field), _of_length(field, value, int(code[:-1])), scales)
    return struct.pack("<" + code, field.to_count(value, scales))


def _pack_list(field: Field, value: Any, scales: Scales) -> bytes:
    size = b""
    if field.code.startswith(COUNTED):
        size = bytes([_countable(field, len(value))])
    if field.items:
        return size + b"".join(pack(field.items, record, scales) for record in value)
    return size + (bytes(value) if field.code.endswith(BYTES) else _pack_items(_item(field), value, scales))


def _pack_rows(field: Field, rows: tuple[tuple[float, ...], ...], scales: Scales) -> bytes:
    width = len(rows[0]) if rows else 0
    shape = bytes([_countable(field, len(rows)), _countable(field, width)])
    return shape + b"".join(_pack_items(_item(field), _of_length(field, row, width), scales) for row in rows)


def _pack_items(item: Field, values: Sequence[float], scales: Scales) -> bytes:
    return struct.pack(f"<{len(values)}{item.code}", *(item.to_count(value, scales) for value in values))


def _item(field: Field) -> Field:
    """One count of a field that holds several."""
    return Field(field.code[-1], field.quantity, field.bound, zero=field.zero, name=field.name)


def _text(value: str) -> bytes:
    return value.encode("latin-1", "replace").replace(b"\0", b"")


def _countable(field: Field, size: int) -> int:
    if size > MOST:
        raise EncodeError(f"{field.name} has {size} items, a packet carries at most {MOST}")
    return size


def _of_length(field: Field, values: Sequence[float], size: int) -> Sequence[float]:
    if len(values) != size:
        raise EncodeError(f"{field.name} has {len(values)} items, its packet carries {size}")
    return values


class _Reader:
    """Goes through a body field by field.

    offset: of the next field; beyond the body once a field was cut short.
    """

    def __init__(self, body: bytes, scales: Scales) -> None:
        self.offset = 0
        self._body = body
        self._scales = scales

    def field(self, field: Field) -> Value:
        code = field.code
        if code == STRING:
            return self._string()
        if code.startswith(ROWS):
            return self._rows(field)
        if field.items:
            return self._records(field)
        if code.startswith((COUNTED, TO_THE_END)):
            return self._list(field)
        if code.endswith(BYTES):
            return self._take(int(code[:-1])).split(b"\0", 1)[0].decode("latin-1")
        if len(code) > 1:
            return self._counts(field, int(code[:-1]))
        return self._count(field)

    def _count(self, field: Field) -> float:
        code = "<" + field.code
        at = self.offset
        self.offset += struct.calcsize(code)
        count = struct.unpack_from(code, self._body, at)[0] if self.offset <= len(self._body) else field.zero
        return field.to_value(count, self._scales)

    def _string(self) -> str:
        end = self._body.find(b"\0", self.offset)
        text = self._body[self.offset : len(self._body) if end < 0 else end]
        self.offset += len(text) + 1
        return text.decode("latin-1")

    def _list(self, field: Field) -> Value:
        if field.code.endswith(BYTES):
            return self._take(self._length() if field.code.startswith(COUNTED) else self._left())
        size = struct.calcsize("<" + field.code[-1])
        return self._counts(field, self._length() if field.code.startswith(COUNTED) else self._left() // size)

    def _records(self, field: Field) -> tuple[Any, ...]:
        """As many as are all there."""
        announced = self._length() if field.code.startswith(COUNTED) else MOST
        records: list[Any] = []
        while len(records) < announced and (self._left() or field.code.startswith(COUNTED)):
            values = [self.field(each) for each in field.items]
            if self.offset > len(self._body):
                break
            records.append(field.record(*values) if field.record else tuple(values))
        return tuple(records)

    def _rows(self, field: Field) -> tuple[Any, ...]:
        count, width = self._length(), self._length()
        rows = [self._counts(field, width) for _ in range(count if width else 0)]
        return tuple(rows)

    def _counts(self, field: Field, announced: int) -> tuple[float, ...]:
        """As many as are all there, of those announced."""
        code = field.code[-1]
        size = struct.calcsize("<" + code)
        present = min(announced, self._left() // size)
        counts = struct.unpack_from(f"<{present}{code}", self._body, min(self.offset, len(self._body)))
        self.offset += announced * size
        if field.bound is None and not field.zero:
            scale = self._scales[field.quantity]
            return counts if field.quantity is Quantity.COUNT else tuple(count * scale for count in counts)
        return tuple(field.to_value(count, self._scales) for count in counts)

    def _length(self) -> int:
        """A count byte."""
        self.offset += 1
        return self._body[self.offset - 1] if self.offset <= len(self._body) else 0

    def _take(self, size: int) -> bytes:
        self.offset += size
        return self._body[self.offset - size : self.offset]

    def _left(self) -> int:
        return max(0, len(self._body) - self.offset)

"""The types of message fields by their ROS names, as annotations of Python types.

A message class is a dataclass whose annotations are these, other message classes, or lists of those; `definition` reads
the input of the serialisers from it.
"""

from dataclasses import fields
from typing import Annotated, Any, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import NDArray
from rosbags.interfaces import Nodetype

Bool = Annotated[bool, "bool"]
Byte = Annotated[int, "byte"]
UInt8 = Annotated[int, "uint8"]
UInt16 = Annotated[int, "uint16"]
Int32 = Annotated[int, "int32"]
UInt32 = Annotated[int, "uint32"]
Float32 = Annotated[float, "float32"]
Float64 = Annotated[float, "float64"]
String = Annotated[str, "string"]
Strings = Annotated[list[str], "string[]"]
Bytes = Annotated[NDArray[np.uint8], "uint8[]"]
Ints8 = Annotated[NDArray[np.int8], "int8[]"]
Ints32 = Annotated[NDArray[np.int32], "int32[]"]
Floats32 = Annotated[NDArray[np.float32], "float32[]"]
Floats64 = Annotated[NDArray[np.float64], "float64[]"]
Matrix3 = Annotated[NDArray[np.float64], "float64[9]"]
Matrix34 = Annotated[NDArray[np.float64], "float64[12]"]
Matrix6 = Annotated[NDArray[np.float64], "float64[36]"]

Definition = tuple[list[Any], list[tuple[str, Any]]]
"""No constants, and the fields, in the form of rosbags."""


def definition(message_class: Any) -> Definition:
    """Return the fields of a message class."""
    hints = get_type_hints(message_class, include_extras=True)
    return [], [(field.name, _node(hints[field.name])) for field in fields(message_class)]


def _node(hint: Any) -> tuple[Nodetype, Any]:
    if get_origin(hint) is list:
        return Nodetype.SEQUENCE, (_node(*get_args(hint)), 0)
    if get_origin(hint) is not Annotated:
        return Nodetype.NAME, hint.__msgtype__
    name, bracket, size = hint.__metadata__[0].partition("[")
    base = Nodetype.BASE, (name, 0)
    if not bracket:
        return base
    return (Nodetype.ARRAY, (base, int(size[:-1]))) if size != "]" else (Nodetype.SEQUENCE, (base, 0))

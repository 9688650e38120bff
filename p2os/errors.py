"""What can go wrong on the wire.

P2OSError
 +-- EncodeError (ValueError)       a value does not fit its field
 +-- DecodeError (ValueError)       a sound frame carries unknown content
 +-- LocalProtocolError             we broke the protocol: our bug
"""


class P2OSError(Exception):
    """Root of everything this package raises."""


class EncodeError(P2OSError, ValueError):
    """A value does not fit its field."""


class DecodeError(P2OSError, ValueError):
    """A sound frame carries content that its packet type does not allow."""


class LocalProtocolError(P2OSError):
    """We broke the protocol."""


def check_bytes(what: str, value: object) -> None:
    """Check the type of an argument that holds bytes.

    Raises:
        TypeError: It is of another type; the message names the argument.
    """
    if not isinstance(value, (bytes, bytearray, memoryview)):  # a union of types takes three times as long
        raise TypeError(f"{what} must be bytes, not {value!r}")

"""The handshake SYNC0, SYNC1, SYNC2 and the connection states behind it, for host and for robot.

Source: Pioneer 3 operations manual, client-server communications; the rules for stray SYNCs are what clients need.
"""

from collections.abc import Mapping
from enum import Enum, StrEnum
from typing import NamedTuple

from p2os.command_table import Command
from p2os.errors import LocalProtocolError
from p2os.framing import encode_frame
from p2os.robot_model import MAX_NAME
from p2os.sip import SIP_TYPES


class Identity(NamedTuple):
    """A robot's answer to SYNC2."""

    name: str
    robot_type: str
    subtype: str

    @classmethod
    def read(cls, payload: bytes) -> "Identity | None":
        """Return the three strings of a SYNC2 answer; None if they are not there, as in the echo of our own SYNC2."""
        texts = payload[1:].decode("latin-1").removesuffix("\0").split("\0")
        return cls(*texts[:3]) if len(texts) >= 3 and all(texts[1:3]) else None


class ConnectionCommand(StrEnum):
    """Meaning of commands 0, 1 and 2 on a synchronised connection, in this order."""

    PULSE = "PULSE"
    OPEN = "OPEN"
    CLOSE = "CLOSE"


CONNECTION_COMMANDS = tuple(ConnectionCommand)


class ConnectionState(Enum):
    """How far a connection is: WAIT, then one state per SYNC answered, then OPEN."""

    WAIT = "wait"
    SYNC0_ANSWERED = "SYNC0 answered"
    SYNC1_ANSWERED = "SYNC1 answered"
    SYNCED = "synced"
    OPEN = "open"


_SYNC0 = bytes([Command.SYNC0])
_SYNC1 = bytes([Command.SYNC1])
_SYNC2 = bytes([Command.SYNC2])
_NEXT_SYNC: Mapping[bytes, bytes] = {_SYNC0: _SYNC1, _SYNC1: _SYNC2}
_SIPS = tuple(bytes([packet_type]) for packet_type in SIP_TYPES)

_ROBOT_STATES: Mapping[tuple[ConnectionState, bytes], ConnectionState] = {
    # SYNC0 always restarts the sequence, and a repeat of the SYNC answered last is answered again.
    (ConnectionState.WAIT, _SYNC0): ConnectionState.SYNC0_ANSWERED,
    (ConnectionState.SYNC0_ANSWERED, _SYNC0): ConnectionState.SYNC0_ANSWERED,
    (ConnectionState.SYNC0_ANSWERED, _SYNC1): ConnectionState.SYNC1_ANSWERED,
    (ConnectionState.SYNC1_ANSWERED, _SYNC0): ConnectionState.SYNC0_ANSWERED,
    (ConnectionState.SYNC1_ANSWERED, _SYNC1): ConnectionState.SYNC1_ANSWERED,
    (ConnectionState.SYNC1_ANSWERED, _SYNC2): ConnectionState.SYNCED,
    (ConnectionState.SYNCED, _SYNC0): ConnectionState.SYNC0_ANSWERED,
    (ConnectionState.SYNCED, _SYNC2): ConnectionState.SYNCED,
}
"""(state, one-byte payload) to the state behind the answer; what is not here is not answered."""


class RobotHandshake:
    """The robot's side: answers SYNCs, follows OPEN and CLOSE.

    state: where the connection stands.
    """

    def __init__(self, identity: Identity) -> None:
        for text in identity:
            if len(text) > MAX_NAME or "\0" in text:
                raise LocalProtocolError(f"{text!r} does not fit the SYNC2 answer, which carries {MAX_NAME} characters")
        self._welcome = _SYNC2 + b"".join(text.encode("latin-1", "replace") + b"\0" for text in identity)
        self.state = ConnectionState.WAIT

    def receive(self, payload: bytes) -> bytes | None:
        """Take the payload of a frame; only SYNCs, OPEN and CLOSE matter here.

        Returns:
            The payload to answer, or None.
        """
        if self.state is not ConnectionState.OPEN:
            following = _ROBOT_STATES.get((self.state, payload))
            if following is not None:
                self.state = following
                return self._welcome if payload == _SYNC2 else payload
        self._open_or_close(payload)
        return None

    def reset(self) -> None:
        """Forget the connection, as a power cycle does."""
        self.state = ConnectionState.WAIT

    def _open_or_close(self, payload: bytes) -> None:
        match self.state, payload[0] if payload else None:
            case ConnectionState.SYNCED, Command.OPEN:
                self.state = ConnectionState.OPEN
            case ConnectionState.OPEN, Command.CLOSE:
                self.state = ConnectionState.WAIT
            case _, Command.CLOSE if len(payload) > 1:
                # A lone 02 out of turn may be a SYNC2 too many; with an argument it is a CLOSE in every state.
                self.state = ConnectionState.WAIT


class HostHandshake:
    """The host's side: asks SYNC0, SYNC1, SYNC2 and reads the robot's identity.

    identity: what the robot answered, None until then.
    streaming: a SIP came instead of an answer: the robot is still open, and wants a CLOSE before it answers.
    """

    def __init__(self) -> None:
        self.identity: Identity | None = None
        self.streaming = False
        self._expected = _SYNC0

    def request(self) -> bytes:
        """The frame to send next, again after every silence."""
        return encode_frame(self._expected)

    def receive(self, payload: bytes) -> Identity | None:
        """Take the payload of a frame.

        A late or repeated answer changes nothing; anything that is no answer starts the sequence again at SYNC0.

        Returns:
            The robot's identity once SYNC2 is answered.
        """
        if payload == self._expected != _SYNC2:
            self._expected = _NEXT_SYNC[payload]
            self.streaming = False
        elif payload[:1] == self._expected == _SYNC2:
            self.identity = Identity.read(payload)
        elif payload[:1] not in (_SYNC0, _SYNC1, _SYNC2):
            self.restart()
            self.streaming = payload[:1] in _SIPS
        return self.identity

    def restart(self) -> None:
        """Begin again at SYNC0."""
        self.identity = None
        self.streaming = False
        self._expected = _SYNC0

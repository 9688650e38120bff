"""Plays a recording: which samples are due, and publishing them on a bus.

`Playback` has no clock: the time is an argument, in s of any steady clock. `PlaybackPublisher` publishes on a bus
between processes; on a `MemoryBus` of its own it shows a recording like a live team, with tokens and descriptions.
"""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from bus import keys
from bus.bus import Bus, Closeable, Sample, Subscription
from bus.errors import BusError, KeyNotValid, MessageError
from bus.messages import decode, encode
from bus.payload import decode_json
from recorder.channels import FASTEST, SLOWEST, TOKENS, is_stream
from recorder.recording import McapRecording, Recorded


class Playback:
    """A position in a recording that moves with time.

    position_ns: time in the recording, ns since 1970. is_paused: it stands still. ended: nothing is left.
    """

    def __init__(self, recording: McapRecording, speed: float = 1.0, loop: bool = False) -> None:
        """Stand at the beginning, paused until `resume`.

        Args:
            recording: What is played.
            speed: Recorded seconds per second.
            loop: Begin again at the end.
        Raises:
            ValueError: The speed is not between `SLOWEST` and `FASTEST`.
        """
        self._recording = recording
        self._loop = loop
        self._speed = _checked(speed)
        self.position_ns = recording.start_ns
        self._resumed: tuple[float, int] | None = None  # when, and the position
        self._samples: Iterator[Recorded] = recording.samples()
        self._next = next(self._samples, None)

    @property
    def is_paused(self) -> bool:
        """Whether it stands still."""
        return self._resumed is None

    @property
    def ended(self) -> bool:
        """Whether nothing is left."""
        return self._next is None

    @property
    def speed(self) -> float:
        """Recorded seconds per second."""
        return self._speed

    @property
    def elapsed(self) -> float:
        """The position in s since the first message."""
        return (self.position_ns - self._recording.start_ns) / 1e9

    def resume(self, now: float) -> None:
        """Go on from the position."""
        self._resumed = now, self.position_ns

    def pause(self, now: float) -> None:
        """Stand still. What is due until now stays due."""
        if self._resumed is not None:
            self.position_ns = min(self._position(now), self._next.time_ns if self._next else self._recording.end_ns)
            self._resumed = None

    def set_speed(self, speed: float, now: float) -> None:
        """Change the speed. Raises: ValueError, as the constructor."""
        _checked(speed)
        if self._resumed is not None:
            self._resumed = now, self._position(now)
        self._speed = speed

    def seek(self, elapsed: float, now: float) -> None:
        """Go to a position, s since the first message; to the nearest one in the recording."""
        last = self._recording.duration
        self.position_ns = self._recording.start_ns + int(min(max(elapsed, 0.0), last) * 1e9)
        self._samples = self._recording.samples(self.position_ns)
        self._next = next(self._samples, None)
        if self._resumed is not None:
            self._resumed = now, self.position_ns

    def due(self, now: float) -> list[Recorded]:
        """Return the samples that are due, in their order; none while it is paused."""
        if self._resumed is None:
            return []
        position = self._position(now)
        found = []
        while self._next is not None and self._next.time_ns <= position:
            found.append(self._next)
            self._next = next(self._samples, None)
        self.position_ns = min(position, self._recording.end_ns)
        if self._next is None and self._loop:
            self.seek(0.0, now)
        return found

    def next_at(self) -> float | None:
        """Return when the next sample is due, on the caller's clock; None while it is paused or has ended."""
        if self._resumed is None or self._next is None:
            return None
        since, position = self._resumed
        return since + (self._next.time_ns - position) / 1e9 / self._speed

    def _position(self, now: float) -> int:
        assert self._resumed is not None
        since, position = self._resumed
        return position + int((now - since) * 1e9 * self._speed)


def _checked(speed: float) -> float:
    if not SLOWEST <= speed <= FASTEST:
        raise ValueError(f"a speed of {speed:g} is not possible; choose one from {SLOWEST:g} to {FASTEST:g}")
    return speed


class PlaybackPublisher(Closeable):
    """Publishes recorded samples on a bus, never on a key on which programs are told to do something.

    published: how many. left_out: keys of samples that are not published, for example `happy/cmd_vel`.
    """

    def __init__(self, bus: Bus, renamed: Mapping[str, str] | None = None, *, with_presence: bool = False) -> None:
        """Prepare.

        Args:
            bus: Where to publish.
            renamed: New names of robots and teams by their old ones.
            with_presence: Show recorded tokens and answer with recorded descriptions as well. Only for a bus in this
                process: to other programs such a robot would look as if it could be told to do something.
        Raises:
            KeyNotValid: A new name is not valid for a robot.
        """
        self.published = 0
        self.left_out: set[str] = set()
        self._bus = bus
        self._renamed = {old: keys.robot_name(new) for old, new in (renamed or {}).items()}
        self._with_presence = with_presence
        self._tokens: dict[str, Subscription] = {}
        self._served: dict[str, Subscription] = {}
        self._descriptions: dict[str, dict[str, Any]] = {}

    def publish(self, recorded: Recorded) -> None:
        """Publish one sample, or leave it out.

        Raises:
            BusError: The bus is closed, or does not let this program publish on the key.
        """
        sample = recorded.sample
        chunks = sample.key.split("/")
        if sample.key == TOKENS or chunks[-1] == "description":
            if self._with_presence:
                self._show(sample)
            return
        if self._with_presence and keys.topic_of(sample.key) is keys.LEASE_STATE:
            self._show(sample)  # a gateway answers with it as well
        if not is_stream(sample.key):
            self.left_out.add(sample.key)
            return
        renamed = self._renamed.get(chunks[0])
        if renamed is not None:
            payload = _with_frames_renamed(sample, chunks[0], renamed)
            sample = Sample("/".join([renamed, *chunks[1:]]), payload, sample.encoding)
        try:
            self._bus.deliver(sample)
            self.published += 1
        except KeyNotValid:  # of a file of other programs
            self.left_out.add(sample.key)

    def show_only(self, presence: Iterable[Recorded]) -> None:
        """Show the tokens and descriptions of another position, after a jump.

        Tokens that stand at both positions are not withdrawn.

        Args:
            presence: As `presence_at` yields it.
        """
        shown = list(presence)
        alive: dict[str, bool] = {}
        for each in shown:
            if (token := _token_of(each.sample)) is not None:
                alive[self._new_key(token[0])] = token[1]
        for key in [key for key in self._tokens if not alive.get(key)]:
            self._show_token(key, False)
        for each in shown:
            if each.sample.key != TOKENS:
                self._show(each.sample)
        for key, is_alive in alive.items():
            self._show_token(key, is_alive)

    def stand_still(self) -> None:
        """Withdraw all tokens and descriptions, for a jump to another position."""
        for each in (*self._tokens.values(), *self._served.values()):
            each.close()
        self._tokens.clear()
        self._served.clear()

    def close(self) -> None:
        """Withdraw what is shown."""
        self.stand_still()

    def _show(self, sample: Sample) -> None:
        """Show a token, or keep a description; what is malformed shows nothing."""
        try:
            if sample.key == TOKENS:
                if (token := _token_of(sample)) is not None:
                    self._show_token(self._new_key(token[0]), token[1])
                return
            key = self._new_key(sample.key)
            self._descriptions[key] = decode_json(sample.payload)
            if key not in self._served:
                self._served[key] = self._bus.serve(key, lambda given: self._descriptions[key])
        except (KeyNotValid, MessageError):
            self.left_out.add(sample.key)

    def _show_token(self, key: str, is_alive: bool) -> None:
        if is_alive and key not in self._tokens:
            self._tokens[key] = self._bus.declare_alive(key)
        elif not is_alive:
            for held in (
                self._tokens.pop(key, None),
                self._served.pop(f"{key.removesuffix('/alive')}/description", None),
            ):
                if held is not None:
                    held.close()

    def _new_key(self, key: str) -> str:
        platform, slash, rest = key.partition("/")
        return self._renamed.get(platform, platform) + slash + rest


def _token_of(sample: Sample) -> tuple[str, bool] | None:
    """Return the key of a token of a recording, and whether it appeared; None for other samples, or malformed ones."""
    if sample.key != TOKENS:
        return None
    try:
        value = decode_json(sample.payload)
    except MessageError:  # it tells of no token
        return None
    match value:
        case {"key": str(key), "alive": bool(is_alive)}:
            return key, is_alive
    return None


def presence_at(recording: McapRecording, time_ns: int) -> Iterator[Recorded]:
    """Yield the tokens and descriptions from the beginning until a time, for a publisher that jumps to it."""

    def is_wanted(key: str) -> bool:
        return key == TOKENS or key.endswith("/description")

    for recorded in recording.samples(is_wanted=is_wanted):
        if recorded.time_ns >= time_ns:
            return
        yield recorded


def platforms(recording: McapRecording, renamed: Mapping[str, str]) -> list[str]:
    """Return the robots and teams under whose names a recording is published."""
    found = {each.key.partition("/")[0] for each in recording.channels if is_stream(each.key)}
    return sorted({renamed.get(each, each) for each in found})


def _with_frames_renamed(sample: Sample, old: str, new: str) -> bytes:
    """Return the payload of a sample whose frames `old/...` are called `new/...`; as it was if it is not decoded."""
    if not sample.type_name or f"{old}/".encode() not in sample.payload:
        return sample.payload
    try:
        message = decode(sample.type_name, sample.payload)
        _rename_frames(message, f"{old}/", f"{new}/")
        return encode(message)
    except (MessageError, BusError):
        return sample.payload


def _rename_frames(message: Any, old: str, new: str) -> None:
    for name, value in vars(message).items():
        match value:
            case str() if name in ("frame_id", "child_frame_id") and value.startswith(old):
                setattr(message, name, new + value.removeprefix(old))
            case list():
                for each in value:
                    if hasattr(each, "__msgtype__"):
                        _rename_frames(each, old, new)
            case _ if hasattr(value, "__msgtype__"):
                _rename_frames(value, old, new)

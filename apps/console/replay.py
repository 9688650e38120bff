"""A recording that the console shows like a live team: play, pause, seek, speed.

It is published on a bus of this process, on which no robot lives. So nothing that is done in the console can reach one.
"""

import asyncio
import time
from collections.abc import Mapping, Sequence
from typing import Any

from apps.console.recorded_history import RecordedHistory, is_reading
from apps.console.timeline import Timeline
from bus import CDR, Bus, MessageError, Sample, keys
from bus.bus import Closeable
from bus.messages import decode, encode
from recorder.playback import Playback, PlaybackPublisher, presence_at
from recorder.recording import McapRecording, Recorded

_TURN = 0.02  # s at most between two looks at what is due
_SLICE = 0.02  # s of publishing after which browsers are served
_WINDOW = 1_500_000_000  # ns before a position whose newest messages are shown after a jump
_REPEAT = 0.5  # s between two repetitions of the newest messages while it is paused, for pages that are opened then


class Replay(Closeable):
    """A recording that is played.

    timeline: what happened in it, once that has been read. history: likewise; None before. words: its files, for
    people.
    """

    SPEEDS = (0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0)
    """Recorded seconds per second that can be chosen."""

    def __init__(self, recording: McapRecording, bus: Bus) -> None:
        """Begin at the start, paused.

        Args:
            recording: What is shown.
            bus: Where it is published; only the console is on it.
        """
        self.timeline = Timeline(self.now)
        self.history: RecordedHistory | None = None
        self.words = ", ".join(path.name for path in recording.paths)
        self._recording = recording
        self._playback = Playback(recording)
        self._now_ns = recording.start_ns
        self._publisher = PlaybackPublisher(bus, with_presence=True)
        self._newest: dict[str, Recorded] = {}  # of each stream of messages, for repetition
        self._busy = asyncio.Lock()

    @property
    def duration(self) -> float:
        """s between the first and the last message."""
        return self._recording.duration

    @property
    def elapsed(self) -> float:
        """The position, s since the first message."""
        return self._playback.elapsed

    @property
    def speed(self) -> float:
        """Recorded seconds per second."""
        return self._playback.speed

    @property
    def is_paused(self) -> bool:
        """Whether it stands still."""
        return self._playback.is_paused

    @property
    def notes(self) -> Sequence[str]:
        """What cannot be read, a sentence each."""
        return self._recording.notes

    def now(self) -> float:
        """Return when the newest message that is shown was recorded, s since 1970."""
        return self._now_ns / 1e9

    def missions(self) -> dict[str, dict[str, Any]]:
        """Return the missions of the indoor navigations at the position, by robot; none before the history is read."""
        return self.history.missions.at(self._now_ns) if self.history is not None else {}

    def position_of(self, at: float) -> float:
        """Return the position of a time: s since the first message, by s since 1970."""
        return at - self._recording.start_ns / 1e9

    def play(self) -> None:
        """Go on; from the beginning if it has ended."""
        if self._playback.ended:
            self._playback.seek(0.0, _clock())
        self._playback.resume(_clock())

    def pause(self) -> None:
        """Stand still."""
        self._playback.pause(_clock())

    def set_speed(self, speed: float) -> None:
        """Change the speed to one of `SPEEDS`.

        Raises:
            ValueError: It is none of them.
        """
        if speed not in self.SPEEDS:
            raise ValueError(f"a speed of {speed:g} is not offered")
        self._playback.set_speed(speed, _clock())

    async def seek(self, elapsed: float) -> None:
        """Go to a position, s since the first message, and show what the streams had last before it."""
        async with self._busy:
            self._playback.seek(elapsed, _clock())
            position = self._playback.position_ns
            before = await asyncio.to_thread(self._read_before, position)
            presence, samples = before
            self._publisher.show_only(presence)
            self._newest = {}
            for recorded in samples:
                self._publish(recorded)
            self._now_ns = position
            self._playback.seek(elapsed, _clock())  # from now on; reading took a while

    async def read_history(self) -> None:
        """Read the events and paths of the whole recording, on a thread and by a reader of its own."""
        paths = self._recording.paths

        def read() -> RecordedHistory:
            with McapRecording.open(paths) as recording:
                return RecordedHistory.of(recording)

        self.history = await asyncio.to_thread(read)
        self.timeline = self.history.timeline

    async def run(self) -> None:
        """Play until this is cancelled."""
        repeated = 0.0
        while True:
            if self._playback.is_paused:
                if _clock() - repeated >= _REPEAT:
                    repeated = _clock()
                    for recorded in self._newest.values():
                        self._publisher.publish(recorded)
                await asyncio.sleep(_TURN)
                continue
            async with self._busy:
                await self._publish_due()
            if self._playback.ended:
                self.pause()
            at = self._playback.next_at()
            await asyncio.sleep(min(max(at - _clock(), 0.0), _TURN) if at is not None else _TURN)

    def close(self) -> None:
        """End it."""
        self._publisher.close()

    async def _publish_due(self) -> None:
        begun = _clock()
        for recorded in self._playback.due(begun):
            self._publish(recorded)
            if _clock() - begun > _SLICE:
                await asyncio.sleep(0.0)
                begun = _clock()

    def _publish(self, recorded: Recorded) -> None:
        if recorded.sample.encoding.startswith(CDR):
            self._newest[recorded.sample.key] = recorded
        self._now_ns = recorded.time_ns
        self._publisher.publish(recorded)

    def _read_before(self, position: int) -> tuple[list[Recorded], list[Recorded]]:
        """Read the tokens and descriptions until a time, ns since 1970, and the newest messages of the streams."""
        recording = self._recording
        presence = list(presence_at(recording, position))
        window: dict[str, list[Recorded]] = {}
        for recorded in recording.samples(position - _WINDOW, is_reading):
            if recorded.time_ns > position:
                break
            window.setdefault(recorded.sample.key, []).append(recorded)
        found = [_merged(each) for each in window.values()]
        slow: Mapping[str, int] = self.history.newest_before(position) if self.history is not None else {}
        for key, at in slow.items():
            newest = next(recording.samples(at, key.__eq__), None) if key not in window else None
            if newest is not None:
                found.append(newest)
        return presence, sorted(found, key=lambda recorded: recorded.time_ns)


def _merged(samples: Sequence[Recorded]) -> Recorded:
    """Return the newest of the samples of a stream; for the sonar, with the newest range of each disc."""
    newest = samples[-1]
    if keys.topic_of(newest.sample.key) is not keys.SONAR:
        return newest
    try:
        messages = [decode(keys.SONAR.type_name, each.sample.payload) for each in samples]
        messages[-1].ranges = list({row.header.frame_id: row for each in messages for row in each.ranges}.values())
        payload = encode(messages[-1])
    except MessageError:  # as it was recorded; whoever reads it sees what is wrong
        return newest
    return newest._replace(sample=Sample(newest.sample.key, payload, newest.sample.encoding))


def _clock() -> float:
    return time.monotonic()

"""The buzzer and the sounds: what SAY and SOUND play, noted down so that people and tests can hear it.

Source: fact sheet section 4, SAY after the Pioneer 3 manual; the other families are assumed to count tones likewise,
and notes to wait until those before them have ended. The sounds of an AmigoBot differ from robot to robot: these are
assumed.
"""

from collections import deque
from typing import NamedTuple

from p2os.accessories.notes import HIGHEST_NOTE, MOST_NOTES, NOTE_UNIT, TONE_STEP
from p2os.accessory_packets import PlaylistEntry
from p2os.firmware import Family

CONCERT_PITCH = 440.0
CONCERT_PITCH_MIDI = 69
KEPT = 50
"""Notes that are remembered."""


class _PlaylistSound(NamedTuple):
    """A sound of the playlist. seconds: how long it is."""

    name: str
    seconds: float


RATE = 8000
"""Bytes of a second of sound (assumed)."""
SOUNDS = {
    Family.AMIGOS: (
        _PlaylistSound("~robot", 0.0),
        _PlaylistSound("hello", 0.8),
        _PlaylistSound("ready", 0.6),
        _PlaylistSound("~signals", 0.0),
        _PlaylistSound("beep", 0.2),
        _PlaylistSound("ouch", 0.5),
    )
}


class PlayedNote(NamedTuple):
    """Something that was played.

    time: when it began, s since power-on. frequency: Hz; None for a rest, and for a sound. seconds: how long.
    sound: name of the sound, empty for a note.
    """

    time: float
    frequency: float | None
    seconds: float
    sound: str = ""


class Buzzer:
    """Plays one thing after the other.

    notes: what was played last, oldest first. on: SOUNDTOG; what comes while it is off is not played.
    """

    __slots__ = ("_ends", "_sounds", "notes", "on")

    def __init__(self, family: Family) -> None:
        self.notes: deque[PlayedNote] = deque(maxlen=KEPT)
        self.on = True
        self._ends = 0.0
        self._sounds = SOUNDS.get(family, ())

    def say(self, pairs: bytes, now: float) -> None:
        """SAY: durations and tones, by turns."""
        for count, tone in zip(pairs[: 2 * MOST_NOTES : 2], pairs[1::2], strict=False):
            self._play(now, _frequency(tone), count * NOTE_UNIT, "")

    def sound(self, number: int, now: float) -> None:
        """SOUND, counted from 1; one that is not there is not played."""
        if 1 <= number <= len(self._sounds):
            name, seconds = self._sounds[number - 1]
            self._play(now, None, seconds, name)

    def plays(self, now: float) -> bool:
        """Return whether a note, a rest between two or a sound is being played."""
        return now < self._ends

    def playlist(self, number: int) -> list[PlaylistEntry]:
        """The answer to PLAYLIST: one sound, or with 0 how many there are and then all of them."""
        offset = 0
        entries = []
        for index, sound in enumerate(self._sounds, 1):
            length = round(sound.seconds * RATE)
            entries.append(PlaylistEntry(index, self.on, sound.name, offset, length))
            offset += length
        if number == 0:
            return [PlaylistEntry(len(entries), self.on, "", 0, offset), *entries]
        return entries[number - 1 : number] if number > 0 else []

    def _play(self, now: float, frequency: float | None, seconds: float, sound: str) -> None:
        if self.on:
            begins = max(now, self._ends)
            self._ends = begins + seconds
            self.notes.append(PlayedNote(begins, frequency, seconds, sound))


def _frequency(tone: int) -> float | None:
    """Return the frequency of a tone of SAY, Hz; None for a rest."""
    if tone == 0:
        return None
    if tone <= HIGHEST_NOTE:
        return float(CONCERT_PITCH * 2 ** ((tone - CONCERT_PITCH_MIDI) / 12))
    return (tone - HIGHEST_NOTE) * TONE_STEP

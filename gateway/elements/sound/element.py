"""The buzzer, and the sounds of an AmigoBot.

Source: Pioneer 3 operations manual (SAY), AmigoBot technical manual (SOUND, PLAYLIST), H8-series manual (SOUNDTOG).
"""

from collections.abc import Sequence

from gateway.elements.asked import AskedElement
from gateway.errors import CommandRefused
from p2os import Command, Family, PlaylistEntry, RobotModel
from p2os.accessories.notes import HIGHEST_NOTE, LONGEST_NOTE, MOST_NOTES, NOTE_UNIT
from p2os.arguments import HIGHEST_SOUND, WHOLE_PLAYLIST


class SoundElement(AskedElement[PlaylistEntry]):
    """Every robot has a buzzer; an AmigoBot is asked for its sounds.

    sounds: number to name, as far as they have come.
    """

    takes = (PlaylistEntry,)
    question = Command.PLAYLIST, WHOLE_PLAYLIST
    _family = Family.P2OS
    _has_count = False

    @property
    def has_sounds(self) -> bool:
        """Numbered sounds can be played."""
        return self._family is Family.AMIGOS

    def begin_link(self, model: RobotModel, now: float) -> None:
        """Ask an AmigoBot for its sounds."""
        self.is_present = True
        self._family = model.firmware
        self.sounds: dict[int, str] = {}
        self._has_count = False
        if self.has_sounds:
            super().begin_link(model, now)

    def take(self, packet: PlaylistEntry, now: float) -> None:
        """Take a sound; the first packet of a list only carries their number."""
        super().take(packet, now)
        if self._has_count:
            self.sounds[packet.number] = packet.name
        self._has_count = True

    def play(self, notes: Sequence[object]) -> None:
        """Play notes, one after the other.

        Args:
            notes: (MIDI note, duration in s) each, 0 for a rest; at most `MOST_NOTES`.
        Raises:
            CommandRefused: They are too many, too high, too long or no notes.
        """
        if not 1 <= len(notes) <= MOST_NOTES:
            raise CommandRefused(f"{len(notes)} notes do not fit; send 1 to {MOST_NOTES}")
        self._ask(Command.SAY, b"".join(map(_pair, notes)))

    def play_number(self, number: int) -> None:
        """Play a sound of an AmigoBot.

        Raises:
            CommandRefused: The robot has no such sounds.
        """
        if not self.has_sounds:
            raise CommandRefused(f"a robot with {self._family.value} has no numbered sounds; send notes")
        if not 0 <= number <= HIGHEST_SOUND:
            raise CommandRefused(f"number {number} is not within 0 to {HIGHEST_SOUND}")
        self._ask(Command.SOUND, number)

    def switch(self, on: bool) -> None:
        """Let it sound, or mute it.

        Raises:
            CommandRefused: The firmware cannot be muted.
        """
        if self._family is Family.P2OS:
            raise CommandRefused(f"{self._family.value} cannot mute its buzzer; AROS, ARCOS and AmigOS can")
        self._ask(Command.SOUNDTOG, int(on))


def _pair(note: object) -> bytes:
    match note:
        case [int(tone), int() | float() as duration] if not isinstance(tone, bool) and not isinstance(duration, bool):
            if 0 <= tone <= HIGHEST_NOTE and NOTE_UNIT <= duration <= LONGEST_NOTE:
                return bytes([round(duration / NOTE_UNIT), tone])
    raise CommandRefused(
        f"{note!r} is no note; each is [MIDI note 0 to {HIGHEST_NOTE}, duration {NOTE_UNIT} to {LONGEST_NOTE:g} s]"
    )

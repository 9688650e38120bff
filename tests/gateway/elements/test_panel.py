"""What a robot is told and never answers: sound, charging contacts, display, servos, power outputs."""

from typing import TYPE_CHECKING

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gateway.elements.panel.element import ChargerElement, Display, PowerOutputs, Servos
from gateway.elements.sound.element import SoundElement, _pair
from gateway.errors import CommandRefused
from gateway.settings import Fitted, Settings
from p2os import Command, Configuration, PlaylistEntry

if TYPE_CHECKING:
    from tests.gateway.elements.conftest import MakeStand, Stand


def heard(stand: "Stand") -> list[tuple[object, object]]:
    return [(command.command, command.value) for command in stand.sent()]


def sound_of(stand: "Stand") -> SoundElement:
    stand.connect()
    stand.sent()
    assert isinstance(stand.element, SoundElement)
    return stand.element


def test_notes_become_pairs_of_duration_and_tone(make_stand: "MakeStand") -> None:
    stand = make_stand(SoundElement)
    sound_of(stand).play([[60, 0.2], [0, 0.02], [127, 5.1]])
    assert heard(stand) == [(Command.SAY, bytes([10, 60, 1, 0, 255, 127]))]


@pytest.mark.parametrize("notes", [[], [[60, 0.2]] * 21, [[128, 0.2]], [[60, 0.0]], [[60, 5.2]], [60], [["c", 1]]])
def test_notes_outside_the_limits_are_refused_with_the_limits(make_stand: "MakeStand", notes: list[object]) -> None:
    sound = sound_of(make_stand(SoundElement))
    with pytest.raises(CommandRefused, match=r"1 to 20|0 to 127, duration 0.02 to 5.1 s"):
        sound.play(notes)


@given(st.integers(0, 127), st.floats(0.02, 5.1))
def test_duration_of_any_note_is_right_within_half_a_count(tone: int, duration: float) -> None:
    counts, written = _pair([tone, duration])
    assert written == tone
    assert abs(counts * 0.02 - duration) <= 0.01 + 1e-9


def test_only_an_amigobot_plays_numbered_sounds_and_lists_them(make_stand: "MakeStand") -> None:
    with pytest.raises(CommandRefused, match="ARCOS has no numbered sounds; send notes"):
        sound_of(make_stand(SoundElement)).play_number(3)
    stand = make_stand(SoundElement, "amigo")
    stand.connect()
    assert heard(stand) == [(Command.PLAYLIST, 0)]
    stand.take(PlaylistEntry(2, True, "", 0, 0))
    stand.take(PlaylistEntry(1, True, "hello", 0, 100))
    stand.take(PlaylistEntry(2, True, "bye", 100, 100))
    sound = stand.element
    assert isinstance(sound, SoundElement)
    assert sound.sounds == {1: "hello", 2: "bye"}
    sound.play_number(2)
    assert heard(stand) == [(Command.SOUND, 2)]
    with pytest.raises(CommandRefused, match="0 to 255"):
        sound.play_number(256)


def test_sound_is_muted_where_the_firmware_can(make_stand: "MakeStand") -> None:
    stand = make_stand(SoundElement)
    sound_of(stand).switch(False)
    assert heard(stand) == [(Command.SOUNDTOG, 0)]
    with pytest.raises(CommandRefused, match="cannot mute"):
        sound_of(make_stand(SoundElement, "p2dx")).switch(False)


def test_charging_contacts_are_there_when_the_configuration_says_so(make_stand: "MakeStand") -> None:
    stand = make_stand(ChargerElement)
    stand.connect()
    assert not stand.has_it()
    stand.connect(Configuration(charger=2))
    assert stand.has_it()
    charger = stand.element
    assert isinstance(charger, ChargerElement)
    assert charger.kind == "PowerBot"
    charger.deploy(True)
    assert heard(stand) == [(Command.CHARGE, 1)]


def test_display_shows_what_fits(make_stand: "MakeStand") -> None:
    stand = make_stand(Display)
    stand.connect()
    assert not stand.has_it()
    stand = make_stand(Display, settings=Settings(fitted=Fitted(lcd=True)))
    stand.connect()
    display = stand.element
    assert isinstance(display, Display)
    display.write("hello")
    assert heard(stand) == [(Command.LCDWRITE, b"hello\0")]
    for text in ("x" * 21, "grüße", "\n"):
        with pytest.raises(CommandRefused, match="up to 20 printable ASCII"):
            display.write(text)


def test_servo_pulses_are_counted_in_ten_microseconds_port_by_port(make_stand: "MakeStand") -> None:
    stand = make_stand(Servos)
    stand.connect()
    servos = stand.element
    assert isinstance(servos, Servos)
    servos.move(1, 0.0015)
    servos.move(4, 0.002)
    assert heard(stand) == [(Command.PTUPOS, (1, 150)), (Command.PTUPOS, (4, 200))]
    with pytest.raises(CommandRefused, match="1 to 4"):
        servos.move(5, 0.0015)
    with pytest.raises(CommandRefused, match=r"0 to 0.00255 s"):
        servos.move(1, 0.003)


def test_amigobot_has_no_servo_ports(make_stand: "MakeStand") -> None:
    stand = make_stand(Servos, "amigo")
    stand.connect()
    assert not stand.has_it()


def test_power_outputs_are_switched_as_the_model_can(make_stand: "MakeStand") -> None:
    stand = make_stand(PowerOutputs, "powerbot-sh")
    stand.connect()
    power = stand.element
    assert isinstance(power, PowerOutputs)
    power.switch("laser", False)
    power.switch("3", True)
    assert heard(stand) == [(Command.SETPBIOPORT, (11, 0)), (Command.SETPBIOPORT, (3, 1))]
    stand.connect(Configuration(power_bits=1))
    power.switch("laser", True)
    assert heard(stand) == [(Command.POWER_LRF, 1)]
    with pytest.raises(CommandRefused, match="there are pc, laser, 5v, 12v"):
        power.switch("toaster", True)


def test_pioneer_has_no_power_outputs(make_stand: "MakeStand") -> None:
    stand = make_stand(PowerOutputs, "p3dx-sh")
    stand.connect()
    assert not stand.has_it()

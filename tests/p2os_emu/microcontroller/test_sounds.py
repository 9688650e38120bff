"""SAY, SOUND, SOUNDTOG and PLAYLIST. Source: fact sheet section 4; Amigo manual for the list."""

from collections.abc import Callable
from itertools import pairwise

import pytest

from p2os.accessory_packets import PlaylistEntry
from p2os.command_table import Command
from p2os_emu.microcontroller.buzzer import KEPT
from tests.p2os_emu.microcontroller.bench import MicrocontrollerBench

BenchOf = Callable[..., MicrocontrollerBench]


def say(robot: MicrocontrollerBench, *pairs: tuple[int, int]) -> None:
    robot.send(Command.SAY, bytes(byte for pair in pairs for byte in pair))
    robot.step()


def played(robot: MicrocontrollerBench) -> int:
    return len(robot.controller.notes)


@pytest.mark.parametrize(("tone", "hertz"), [(69, 440.0), (81, 880.0), (60, 261.626), (128, 32.0), (255, 4096.0)])
def test_tones_are_midi_notes_and_then_steps_of_32_hertz(robot: MicrocontrollerBench, tone: int, hertz: float) -> None:
    say(robot, (1, tone))
    assert robot.controller.notes[0].frequency == pytest.approx(hertz, abs=0.001)


def test_notes_are_played_one_after_the_other(robot: MicrocontrollerBench) -> None:
    say(robot, (50, 69), (25, 0), (5, 81))
    first, rest, last = robot.controller.notes
    assert (first.frequency, first.seconds) == pytest.approx((440.0, 1.0))
    assert (rest.frequency, rest.seconds) == (None, 0.5)
    assert (last.frequency, last.seconds) == pytest.approx((880.0, 0.1))
    assert (rest.time - first.time, last.time - first.time) == pytest.approx((1.0, 1.5))
    say(robot, (5, 60))
    assert robot.controller.notes[-1].time == pytest.approx(last.time + last.seconds), "the buzzer was still busy"


def test_a_tune_has_at_most_twenty_notes_and_the_last_fifty_are_remembered(robot: MicrocontrollerBench) -> None:
    say(robot, *[(1, 69)] * 30)
    assert len(robot.controller.notes) == 20
    for _ in range(5):
        say(robot, *[(1, 60)] * 20)
    assert len(robot.controller.notes) == KEPT


def test_a_muted_buzzer_plays_nothing_until_it_is_switched_on_or_the_client_goes(robot: MicrocontrollerBench) -> None:
    robot.send(Command.SOUNDTOG, 0)
    say(robot, (1, 69))
    assert played(robot) == 0
    robot.send(Command.SOUNDTOG, 1)
    say(robot, (1, 69))
    assert played(robot) == 1
    robot.send(Command.SOUNDTOG, 0)
    robot.send(Command.CLOSE)
    robot.step()
    robot.connect()
    say(robot, (1, 69))
    assert played(robot) == 2


def test_half_a_pair_is_no_note(robot: MicrocontrollerBench) -> None:
    robot.send(Command.SAY, b"\x05")
    robot.step()
    assert robot.controller.notes == ()


class TestAmigoBot:
    @pytest.fixture
    def amigo(self, bench_of: BenchOf) -> MicrocontrollerBench:
        return bench_of("amigo").connect()

    def test_the_list_begins_with_how_many_sounds_there_are(self, amigo: MicrocontrollerBench) -> None:
        amigo.send(Command.PLAYLIST, 0)
        head, *sounds = amigo.packets(PlaylistEntry, 0.2)
        assert head.number == len(sounds) > 1
        assert [sound.number for sound in sounds] == list(range(1, len(sounds) + 1))
        assert all(sound.on and sound.name for sound in sounds)
        for sound, following in pairwise(sounds):
            assert sound.offset + sound.length == following.offset

    def test_one_sound_of_the_list(self, amigo: MicrocontrollerBench) -> None:
        amigo.send(Command.PLAYLIST, 2)
        (sound,) = amigo.packets(PlaylistEntry, 0.2)
        assert (sound.number, sound.name) == (2, "hello")

    def test_a_sound_is_played_by_its_number(self, amigo: MicrocontrollerBench) -> None:
        for number in (2, 0, 99, -1):
            amigo.send(Command.SOUND, number)
        amigo.step()
        (note,) = amigo.controller.notes
        assert (note.sound, note.frequency, note.seconds) == ("hello", None, 0.8)


def test_other_robots_have_no_sounds(robot: MicrocontrollerBench) -> None:
    robot.send(Command.SOUND, 1)
    robot.send(Command.PLAYLIST, 0)
    assert [entry.number for entry in robot.packets(PlaylistEntry, 0.2)] == [0]
    assert robot.controller.notes == ()

import pytest
from hypothesis import given
from hypothesis import strategies as st

from acromovi.keyboard import HOLD, PERIOD, Action, KeyboardControl, KeyReader

FORWARD, BACK, LEFT, RIGHT = (0.3, 0.0), (-0.3, 0.0), (0.0, 0.8), (0.0, -0.8)
STILL = (0.0, 0.0)


@pytest.fixture
def keyboard() -> KeyboardControl:
    return KeyboardControl(0.3, 0.8)


@pytest.mark.parametrize(
    ("sent", "keys"),
    [
        (b"w", ["w"]),
        (b"W", ["w"]),
        (b"\x1b[A\x1b[B\x1b[C\x1b[D", ["up", "down", "right", "left"]),
        (b"\x1bOA", ["up"]),  # as a terminal in application mode sends it
        (b"\x1b[Zq", ["special key", "q"]),  # a key that means nothing here
        (b"\x1b[1;5Aq", ["special key", "q"]),  # Ctrl and an arrow: not a turn by its last letter
        (b"\x1b[15~", ["special key"]),
        (b"\x1bOP", ["special key"]),
        (b"\x1bq", ["q"]),
        (b" x", [" ", "x"]),
    ],
)
def test_keys_are_read_wherever_the_bytes_come_apart(sent: bytes, keys: list[str]) -> None:
    assert KeyReader().receive(sent) == keys
    reader = KeyReader()
    assert [key for byte in sent for key in reader.receive(bytes([byte]))] == keys


def test_an_escape_alone_is_noticed_and_nothing_is_made_of_it() -> None:
    reader = KeyReader()
    assert reader.receive(b"\x1b") == []
    assert reader.has_lone_escape
    assert reader.receive(b"[A") == ["up"]
    assert not reader.has_lone_escape


def test_a_sequence_without_an_end_is_given_up() -> None:
    reader = KeyReader()
    assert reader.receive(b"\x1b[" + 40 * b"1")[:2] == ["[", "1"]
    assert reader.receive(b"w")[-1] == "w"


@given(st.binary())
def test_no_bytes_upset_the_reader(data: bytes) -> None:
    reader = KeyReader()
    reader.receive(data)
    assert reader.receive(b"\x1b[A\x1b[Bw")[-2:] == ["down", "w"]


@pytest.mark.parametrize(
    ("key", "twist"),
    [
        ("up", FORWARD),
        ("w", FORWARD),
        ("down", BACK),
        ("s", BACK),
        ("left", LEFT),
        ("a", LEFT),
        ("right", RIGHT),
        ("d", RIGHT),
    ],
)
def test_a_key_drives_while_it_is_held(keyboard: KeyboardControl, key: str, twist: tuple[float, float]) -> None:
    assert keyboard.press(key, 10.0) is None
    assert keyboard.twist(10.0) == twist
    assert keyboard.twist(10.0 + HOLD - 0.01) == twist
    assert keyboard.twist(10.0 + HOLD) == STILL


def test_two_keys_make_an_arc(keyboard: KeyboardControl) -> None:
    keyboard.press("w", 0.0)
    keyboard.press("a", 0.1)
    assert keyboard.twist(0.2) == (0.3, 0.8)
    assert keyboard.twist(HOLD + 0.05) == LEFT


def test_commands_come_at_10_hz_and_end_with_one_zero(keyboard: KeyboardControl) -> None:
    keyboard.press("w", 0.0)
    steps = [(step / 100, keyboard.due(step / 100)) for step in range(200)]
    sent = [(now, twist) for now, twist in steps if twist is not None]
    drives = [now for now, twist in sent if twist == FORWARD]
    assert drives == pytest.approx([PERIOD * i for i in range(round(HOLD / PERIOD))], abs=0.02)
    assert [twist for _, twist in sent if twist != FORWARD] == [STILL]
    assert sent[-1][1] == STILL
    assert sent[-1][0] == pytest.approx(HOLD, abs=0.011)


def test_a_held_key_that_repeats_drives_on_without_a_gap(keyboard: KeyboardControl) -> None:
    for step in range(100):  # first repetition after 0.5 s, then 30 a second
        now = step / 30
        if step == 0 or now >= 0.5:
            keyboard.press("w", now)
        assert keyboard.twist(now) == FORWARD


def test_a_change_of_mind_is_not_kept_waiting(keyboard: KeyboardControl) -> None:
    keyboard.press("w", 0.0)
    assert keyboard.due(0.0) == FORWARD
    keyboard.press("s", 0.01)
    assert keyboard.due(0.01) == BACK


def test_nothing_is_sent_while_no_key_is_touched(keyboard: KeyboardControl) -> None:
    assert all(keyboard.due(step / 10) is None for step in range(100))


@pytest.mark.parametrize(
    ("key", "action"),
    [(" ", Action.STOP), ("e", Action.ENABLE), ("x", Action.ESTOP), ("c", Action.CLEAR), ("q", Action.QUIT)],
)
def test_an_action_ends_the_drive_at_once(keyboard: KeyboardControl, key: str, action: Action) -> None:
    keyboard.press("w", 0.0)
    assert keyboard.due(0.0) == FORWARD
    assert keyboard.press(key, 0.01) is action
    assert keyboard.due(0.01) == STILL
    assert keyboard.due(0.02) is None


def test_other_keys_do_nothing(keyboard: KeyboardControl) -> None:
    assert keyboard.press("k", 0.0) is None
    assert keyboard.twist(0.0) == STILL

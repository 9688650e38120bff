"""Recordings: written line by line, read again with plain errors, and played to clients that differ."""

import json
from pathlib import Path

import pytest

import configs
from p2os import Command, Frame, FrameDecoder, RobotModel, encode_command, encode_frame
from p2os.wire_log import FrameSource
from p2os_emu.emulator import STEP, Emulator
from p2os_emu.links.line import LinkProfile
from p2os_emu.links.memory import MemoryLink
from p2os_emu.recording import LineRecorder, RecordedBytes, Recording, RecordingError, ReplayDevice, read
from tests.p2os_emu.flat_world import FlatWorld

ANSWER = encode_frame(b"\x02happy\0Pioneer\0p3dx-sh\0")
HANDSHAKE = (Command.SYNC0, Command.SYNC1, Command.SYNC2)
CONFIGURATION = encode_frame(b"\x20configuration")
SIP = [encode_frame(bytes([0x32, number])) for number in range(5)]


def host(time: float, command: Command, value: int | None = None) -> RecordedBytes:
    """What a client sent."""
    return RecordedBytes(time, FrameSource.HOST, encode_command(command, value))


def robot(time: float, *frames: bytes) -> RecordedBytes:
    """What a robot sent."""
    return RecordedBytes(time, FrameSource.ROBOT, b"".join(frames))


def drive() -> Recording:
    """A short conversation: handshake, OPEN, CONFIG, five SIPs, CLOSE."""
    return Recording(
        (
            host(0.0, Command.SYNC0),
            robot(0.05, encode_frame(b"\0")),
            host(0.1, Command.SYNC1),
            robot(0.15, encode_frame(b"\1")),
            host(0.2, Command.SYNC2),
            robot(0.25, ANSWER),
            host(0.3, Command.OPEN),
            robot(0.4, SIP[0]),
            host(0.42, Command.CONFIG),
            robot(0.45, CONFIGURATION),
            robot(0.5, SIP[1]),
            host(0.55, Command.PULSE),
            *(robot(0.6 + step / 10, SIP[2 + step]) for step in range(3)),
            host(0.95, Command.CLOSE),
        )
    )


class Client:
    """Talks to a player; time is stepped."""

    def __init__(self, recording: Recording) -> None:
        self.player = ReplayDevice(recording)
        self.decoder = FrameDecoder()

    def say(self, command: Command | None = None, seconds: float = 0.06) -> list[bytes]:
        """Send a command; the frames that come back meanwhile."""
        if command is not None:
            self.player.receive(encode_command(command))
        heard = []
        for step in range(round(seconds / STEP)):
            for event in self.decoder.receive(self.player.step(STEP), step * STEP):
                assert isinstance(event, Frame)
                heard.append(encode_frame(event.payload))
        return heard

    def connect(self) -> None:
        """Shake hands."""
        for command in HANDSHAKE:
            self.say(command)


@pytest.fixture
def client() -> Client:
    return Client(drive())


def test_handshake_is_answered_as_recorded(client: Client) -> None:
    assert [client.say(command) for command in HANDSHAKE] == [[encode_frame(b"\0")], [encode_frame(b"\1")], [ANSWER]]


def test_stream_runs_from_open_to_the_end_of_the_recording(client: Client) -> None:
    client.connect()
    assert client.say(Command.OPEN, 2.0) == SIP


def test_answer_comes_when_the_client_asks_whenever_that_is(client: Client) -> None:
    client.connect()
    client.say(Command.OPEN, 1.0)
    assert client.say(Command.CONFIG) == [CONFIGURATION]
    assert client.say(Command.CONFIG) == [CONFIGURATION], "and again when it asks again"


def test_close_ends_the_stream_and_the_next_client_finds_it_new(client: Client) -> None:
    client.connect()
    assert client.say(Command.OPEN, 0.25) == SIP[:2]
    assert client.say(Command.CLOSE, 1.0) == []
    client.connect()
    assert client.say(Command.OPEN, 0.25) == SIP[:2]


def test_what_was_never_recorded_is_not_answered(client: Client) -> None:
    client.connect()
    assert client.say(Command.ESTOP) == []


def test_syncs_out_of_turn_are_not_answered(client: Client) -> None:
    assert client.say(Command.SYNC2) == []
    assert client.say(Command.SYNC1) == []
    assert client.say(Command.SYNC0) == [encode_frame(b"\0")]
    assert client.say(Command.SYNC0) == [encode_frame(b"\0")]


def test_recording_that_begins_in_the_middle_plays_at_once() -> None:
    client = Client(Recording((robot(0.0, SIP[0]), robot(0.1, SIP[1]))))
    assert client.say(None, 0.5) == SIP[:2]


def test_rate_is_what_the_client_sets(client: Client) -> None:
    assert client.player.baud == 9600
    client.player.receive(encode_command(Command.HOSTBAUD, 4))
    assert client.player.baud == 115200


def test_recording_knows_whose_it_is() -> None:
    assert drive().identity == ("happy", "Pioneer", "p3dx-sh")
    assert Recording((host(0.0, Command.SYNC0),)).identity is None


def test_conversation_is_taken_apart_by_what_the_host_said() -> None:
    names = [exchange.name for exchange in drive().exchanges()]
    assert names == ["", "SYNC0", "SYNC1", "SYNC2", "OPEN", "command 18", "PULSE", "CLOSE"]


def test_what_was_recorded_is_read_again(tmp_path: Path) -> None:
    recorder = LineRecorder(tmp_path / "tape", "happy", "p3dx-sh")
    link = MemoryLink()
    emulator = Emulator(FlatWorld(), LinkProfile("ideal"))
    line = emulator.add("happy", configs.load(RobotModel, "robots", "p3dx-sh"), link).line
    line.tap = recorder
    for command in (*HANDSHAKE, Command.OPEN):
        link.client_write(encode_command(command))
        for _ in range(24):
            emulator.step()
    recording = read(tmp_path / "tape")  # not yet closed: every line is in the file as soon as it is written
    recorder.close()
    assert (recording.name, recording.model) == ("happy", "p3dx-sh")
    assert b"".join(moment.data for moment in recording.of(FrameSource.ROBOT)) == link.client_read()
    assert [moment.data for moment in recording.of(FrameSource.HOST)] == [
        encode_command(command) for command in (*HANDSHAKE, Command.OPEN)
    ]
    assert recording.identity == ("happy", "Pioneer", "p3dx-sh")


def test_recording_of_others_needs_no_header(tmp_path: Path) -> None:
    path = tmp_path / "tape"
    path.write_text('{"t": 0.5, "from": "host", "hex": "fafb03000000"}\n')
    assert read(path).moments == (RecordedBytes(0.5, FrameSource.HOST, encode_command(Command.SYNC0)),)


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("", "holds no bytes"),
        ("nonsense\n", "line 1"),
        ('{"t": 1, "from": "host", "hex": "00"}\n{"t": 1, "from": "nobody", "hex": "00"}\n', "line 2"),
        ('{"t": 1, "from": "host", "hex": "0"}\n', "line 1"),
        ("[]\n", "line 1"),
        ('{"t": NaN, "from": "host", "hex": "00"}\n', "line 1 is no line of a recording as .*hex"),
    ],
)
def test_file_that_is_no_recording_is_refused_with_its_line(tmp_path: Path, text: str, complaint: str) -> None:
    path = tmp_path / "tape"
    path.write_text(text)
    with pytest.raises(RecordingError, match=complaint):
        read(path)


def test_missing_file_and_forbidden_place_are_refused(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="cannot be read"):
        read(tmp_path / "none")
    with pytest.raises(RecordingError, match="choose another path"):
        LineRecorder(tmp_path / "no folder" / "tape", "", "")


def test_lines_are_plain_json(tmp_path: Path) -> None:
    recorder = LineRecorder(tmp_path / "tape", "happy", "p3dx-sh")
    recorder(1.25, "robot", b"\xfa\xfb")
    recorder.close()
    header, line = map(json.loads, (tmp_path / "tape").read_text().splitlines())
    assert header == {"cassette": 3, "name": "happy", "model": "p3dx-sh"}
    assert line == {"t": 1.25, "from": "robot", "hex": "fafb"}


def test_full_disk_is_said_with_the_path() -> None:
    with pytest.raises(RecordingError, match=r"/dev/full cannot be written: .*; choose another path"):
        LineRecorder(Path("/dev/full"), "happy", "p3dx")


def test_a_recording_that_exists_is_overwritten_only_by_force(tmp_path: Path) -> None:
    path = tmp_path / "tape"
    LineRecorder(path, "happy", "p3dx-sh").close()
    before = path.read_text()
    with pytest.raises(RecordingError, match="exists already and would be overwritten"):
        LineRecorder(path, "grumpy", "p2dx")
    assert path.read_text() == before
    LineRecorder(path, "grumpy", "p2dx", force=True).close()
    assert "grumpy" in path.read_text()

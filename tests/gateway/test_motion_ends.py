"""How a long motion ended: told from the robot's SIPs, with what was covered of what was asked for."""

import struct
from math import radians
from typing import TYPE_CHECKING

import pytest

from gateway.events import MotionEnd, MotionEnded
from p2os import Command, FrameDecoder, encode_frame
from p2os.framing import Frame
from tests.gateway.simulator_peer import SimulatorPeer
from tests.gateway.test_simulator import Line

if TYPE_CHECKING:
    from tests.gateway.conftest import Bench


class Inaccurate(SimulatorPeer):
    """Goes a part of each way, or more than that. factor: of the way that is asked for."""

    factor = 1.0

    def receive(self, data: bytes) -> bytes:
        answer = b""
        for found in FrameDecoder().receive(data, 0.0):
            assert isinstance(found, Frame)
            payload = found.payload
            if payload[0] in (Command.MOVE, Command.DHEAD):
                asked = struct.unpack("<H", payload[2:4])[0]
                payload = payload[:2] + struct.pack("<H", round(self.factor * asked))
            answer += super().receive(encode_frame(payload))
        return answer


def end_of(factor: float, kind: str, amount: float) -> MotionEnded:
    peer = Inaccurate()
    line = Line(peer)
    line.connect()
    line.run(1.0)
    peer.factor = factor
    line.driver.move(amount, line.now) if kind == "move" else line.driver.turn(amount, line.now)
    line.run_until(lambda: bool(line.of(MotionEnded)), 30.0)
    return line.of(MotionEnded)[0]


@pytest.mark.parametrize(("kind", "amount", "unit"), [("move", 1.0, "m"), ("move", -0.5, "m"), ("turn", 2.0, "rad")])
@pytest.mark.parametrize(
    ("factor", "end"),
    [(1.2, MotionEnd.OVERSHOOT), (0.8, MotionEnd.UNDERSHOOT), (0.0, MotionEnd.NOT_STARTED), (1.0, MotionEnd.REACHED)],
)
def test_motion_that_ends_elsewhere_says_on_which_side_and_how_far(
    factor: float, end: MotionEnd, kind: str, amount: float, unit: str
) -> None:
    ended = end_of(factor, kind, amount)
    assert ended.end is end
    assert ended.done == pytest.approx(factor * amount, abs=radians(2.0))
    assert (ended.goal, ended.unit) == (amount, unit)


def test_sentence_and_json_carry_the_distance_and_its_unit() -> None:
    over = MotionEnded("move-1", "move", MotionEnd.OVERSHOOT, 1.06, 1.0, "m")
    assert over.sentence == "overshoot by 0.06 m: 1.06 of 1.00 m"
    assert MotionEnded("turn-2", "turn", MotionEnd.UNDERSHOOT, -0.9, -1.0, "rad").sentence == (
        "undershoot by 0.10 rad: -0.90 of -1.00 rad"
    )
    assert (
        MotionEnded("turn-3", "turn", MotionEnd.STALLED, 0.5, 1.0, "rad").sentence == "stalled after 0.50 of 1.00 rad"
    )
    assert over.as_json() == {
        "id": "move-1",
        "command": "move",
        "result": "overshoot",
        "done": 1.06,
        "goal": 1.0,
        "unit": "m",
        "text": over.sentence,
    }


def test_stop_button_ends_a_motion_as_stopped_by_the_robot(bench: "Bench") -> None:
    bench.connect()
    bench.run(1.0)
    bench.driver.move(3.0, bench.now)
    bench.run(1.0)
    bench.robot.panel.stop_button = True
    bench.run_until(lambda: bool(bench.of(MotionEnded)), 5.0)
    assert bench.of(MotionEnded)[0].end is MotionEnd.STOPPED_BY_ROBOT

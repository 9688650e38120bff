"""What the control socket can be asked, in a world without physics on a virtual clock."""

import contextlib
import json
import math
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

import configs
from geometry import Pose2D
from p2os import Command, encode_command
from p2os_emu.control import RequestError
from p2os_emu.control_requests import REQUESTS, ControlRequestHandler
from p2os_emu.emulator import STEP, Emulator
from p2os_emu.faults.board import FaultBoard
from p2os_emu.links.line import LinkProfile
from p2os_emu.links.poller import Poller
from p2os_emu.ports import Ports
from p2os_emu.runner import Runner
from p2os_emu.team import EmulatedTeam
from p2os_emu.world import World, load_world
from tests.p2os_emu.flat_world import FlatWorld


@pytest.fixture(scope="module")
def desk() -> Iterator[ControlRequestHandler]:
    yield from make_desk()


@pytest.fixture
def fresh() -> Iterator[ControlRequestHandler]:
    """A desk that a test may empty."""
    yield from make_desk()


def make_desk() -> Iterator[ControlRequestHandler]:
    poller = Poller()
    emulator = Emulator(FlatWorld(), LinkProfile("ideal"))
    team = EmulatedTeam(emulator, Ports(poller, tcp=0), "ideal", {}, "", ["grumpy=joystick"])
    team.add("p3dx:happy")
    team.add("p3dx-sh:grumpy")
    faults = FaultBoard(emulator.robots)
    emulator.before_step = faults.advance
    yield ControlRequestHandler(team, faults, Runner(emulator, poller, clock=lambda: 0.0, sleep=lambda seconds: None))
    emulator.close()
    poller.close()


def ask(desk: ControlRequestHandler, do: str, **fields: Any) -> dict[str, Any]:
    answer = dict(desk.answer({"do": do, **fields}))
    json.dumps(answer, allow_nan=False)
    return answer


def test_truth_of_all_and_of_one(desk: ControlRequestHandler) -> None:
    assert ask(desk, "pose", robot="happy", x=1.0, y=2, heading=0.5) == {
        "robot": "happy",
        "x": 1.0,
        "y": 2.0,
        "heading": 0.5,
    }
    everybody = ask(desk, "truth")
    assert set(everybody["robots"]) == {"happy", "grumpy"}
    assert everybody["robots"]["happy"]["x"] == 1.0
    one = ask(desk, "truth", robot="happy")
    assert (one["x"], one["y"], one["heading"]) == (1.0, 2.0, 0.5)
    assert (one["late_dropped"], one["lost"], one["degraded"]) == (0, 0.0, [])


def test_truth_tells_touches_people_and_doors(desk: ControlRequestHandler) -> None:
    truth = ask(desk, "truth", robot="happy")
    assert (truth["people"], truth["doors"]) == ({}, {})
    assert (truth["robots"]["happy"]["touches"], truth["robots"]["happy"]["touched"]) == (0, [])


def test_people_touches_and_doors_of_a_real_world_can_be_asked_and_doors_told() -> None:
    with closing(Poller()) as poller, World(load_world("people-lab"), seed=1) as world:
        emulator = Emulator(world, LinkProfile("ideal"))
        lab = ControlRequestHandler(
            EmulatedTeam(emulator, Ports(poller, tcp=0), "ideal", {}, "", []),
            FaultBoard(emulator.robots),
            Runner(emulator, poller, clock=lambda: 0.0, sleep=lambda seconds: None),
        )
        lab.team.add("p3dx-sh:happy", Pose2D(2.5, 0.6, 0.0))
        assert ask(lab, "door", name="door", open=False) == {"door": "door", "open": False}
        for _ in range(round(4.0 / STEP)):
            emulator.step()
        truth = ask(lab, "truth")
        assert set(truth["people"]) == {"Anna", "Bert", "Carl"}
        assert truth["people"]["Anna"]["walks"] is True
        assert truth["doors"]["door"] == {"opening": 0.0, "width": pytest.approx(1.2)}
        happy = truth["robots"]["happy"]
        assert happy["touches"] == 1
        assert happy["touched"][0]["what"] == "Carl"
        with pytest.raises(RequestError, match="did you mean door"):
            ask(lab, "door", name="dor", open=True)
        emulator.close()


def test_pose_without_a_place_only_tells(desk: ControlRequestHandler) -> None:
    before = ask(desk, "pose", robot="grumpy")
    assert ask(desk, "pose", robot="grumpy") == before


def test_fault_is_listed_until_it_is_cleared(desk: ControlRequestHandler) -> None:
    asked = ask(desk, "fault", fault="line-cut:robot=happy@5+10")
    assert asked["end"] - asked["start"] == 10
    assert asked in ask(desk, "faults")["faults"]
    assert ask(desk, "clear", number=asked["number"]) == {"cleared": [asked["number"]]}
    assert ask(desk, "faults")["faults"] == []


def test_joystick_stays_where_it_is_put(desk: ControlRequestHandler) -> None:
    pushed = ask(desk, "joystick", robot="grumpy", y=1.0, button1=True)
    assert pushed == {
        "robot": "grumpy",
        "x": 0.0,
        "y": 1.0,
        "throttle": 1.0,
        "button1": True,
        "button2": False,
    }
    assert ask(desk, "joystick", robot="grumpy", x=-0.5)["y"] == 1.0
    for _ in range(120):
        desk.emulator.step()
    assert ask(desk, "truth", robot="grumpy")["robots"]["grumpy"]["linear"] > 0.2
    assert ask(desk, "joystick", robot="grumpy", x=0, y=0, button1=False)["button1"] is False
    for _ in range(240):
        desk.emulator.step()
    assert ask(desk, "truth", robot="grumpy")["robots"]["grumpy"]["linear"] == 0.0


def test_truth_shows_what_the_board_plays_shows_and_switches(desk: ControlRequestHandler) -> None:
    controller = desk.emulator.robots["grumpy"].microcontroller
    for command, value in (
        (Command.SYNC0, None),
        (Command.SYNC1, None),
        (Command.SYNC2, None),
        (Command.OPEN, None),
        (Command.SAY, bytes([50, 69])),
        (Command.LCDWRITE, b"hello"),
        (Command.PTUPOS, (3, 150)),
        (Command.POWER_LRF, 0),
    ):
        controller.receive(encode_command(command, value))
    desk.emulator.step()
    truth = ask(desk, "truth", robot="grumpy")["robots"]["grumpy"]
    (note,) = truth["notes"]
    assert (note["frequency"], note["seconds"]) == (440.0, 1.0)
    assert truth["lcd"] == "hello"
    assert truth["servos"] == {"3": pytest.approx(1.5e-3)}
    assert not truth["power"]["lrf"]


def test_clear_without_a_number_clears_all(desk: ControlRequestHandler) -> None:
    ask(desk, "fault", fault="line-cut@1")
    ask(desk, "fault", fault="stop-pressed@1")
    assert len(ask(desk, "clear")["cleared"]) == 2


def test_paused_emulator_moves_by_steps(desk: ControlRequestHandler) -> None:
    with pytest.raises(RequestError, match="pause"):
        ask(desk, "step", n=1)
    before = ask(desk, "pause")["time"]
    assert ask(desk, "step", n=12)["time"] == pytest.approx(before + 12 * STEP)
    assert ask(desk, "step")["time"] == pytest.approx(before + 13 * STEP)
    assert ask(desk, "pause", on=False)["paused"] is False


def test_speed_is_told_and_changed(desk: ControlRequestHandler) -> None:
    assert ask(desk, "speed", factor=2)["speed"] == 2.0
    assert ask(desk, "speed")["speed"] == 2.0
    ask(desk, "speed", factor=1.0)


def test_robots_come_and_go(fresh: ControlRequestHandler) -> None:
    entry = ask(fresh, "add", model="p2dx", x=5, y=5)["robot"]
    assert entry["name"] == "p2dx"
    assert entry["port"].startswith("socket://127.0.0.1:")
    assert ask(fresh, "pose", robot="p2dx")["x"] == 5.0
    assert ask(fresh, "add", model="p2dx")["robot"]["name"] == "p2dx-2"
    fitted = ask(fresh, "add", model="p3dx", name="doc", fit="laser,no-rear-sonar")["robot"]
    assert fitted["laser_port"] is not None
    assert ask(fresh, "remove", robot="p2dx") == {"removed": "p2dx"}
    assert "p2dx" not in ask(fresh, "truth")["robots"]


def test_only_robot_need_not_be_named(fresh: ControlRequestHandler) -> None:
    ask(fresh, "remove", robot="grumpy")
    assert ask(fresh, "pose", x=3)["robot"] == "happy"


def test_reset_carries_home(desk: ControlRequestHandler) -> None:
    ask(desk, "pose", robot="grumpy", x=9)
    assert ask(desk, "reset", robot="grumpy") == {"reset": ["grumpy"]}
    assert ask(desk, "pose", robot="grumpy")["x"] == 0.0


def test_reset_of_all_lets_robots_change_places_and_of_one_is_refused_where_another_stands() -> None:
    with closing(Poller()) as poller, World(load_world("empty"), seed=1) as world:
        emulator = Emulator(world, LinkProfile("ideal"))
        team = EmulatedTeam(emulator, Ports(poller, tcp=0), "ideal", {}, "")
        starts = {"happy": Pose2D(5.0, 3.0, 0.0), "doc": Pose2D(7.0, 3.0, 1.0)}
        for name, start in starts.items():
            team.add(f"p3dx:{name}", start)
        clock = Runner(emulator, poller, clock=lambda: 0.0, sleep=lambda seconds: None)
        desk = ControlRequestHandler(team, FaultBoard(emulator.robots), clock)
        world.place_all({"happy": starts["doc"], "doc": starts["happy"]})
        with pytest.raises(RequestError, match=r"cannot stand at \(5\.00, 3\.00\) m: robot 'doc' is in the way"):
            ask(desk, "reset", robot="happy")
        assert ask(desk, "pose", robot="happy")["x"] == pytest.approx(7.0, abs=0.01)
        assert ask(desk, "reset") == {"reset": ["happy", "doc"]}
        for name, start in starts.items():
            assert ask(desk, "pose", robot=name)["x"] == pytest.approx(start.x, abs=0.01)
        emulator.close()


def test_quit_ends_the_run(fresh: ControlRequestHandler) -> None:
    ask(fresh, "quit")
    fresh.runner.run()
    assert fresh.emulator.time == 0.0


@pytest.mark.parametrize(
    ("ours", "theirs", "complaint"),
    [
        ('name = "p3dx"', f'name = "{"x" * 20}"', "name must have 1 to 19 characters"),
        ("[7, ", "[32, ", "sonar numbers must be from 0 to 31, not 32"),
        ("wheel_track_m = ", "wheel_track_m = 0  # ", "wheel_track_m must be a number from 0.0001"),
    ],
)
def test_model_that_no_robot_has_is_refused_and_the_emulator_runs_on(
    desk: ControlRequestHandler, tmp_path: Path, ours: str, theirs: str, complaint: str
) -> None:
    text = configs.find("robots", "p3dx").read_text(encoding="utf-8")
    assert ours in text
    model = tmp_path / "mine.toml"
    model.write_text(text.replace(ours, theirs), encoding="utf-8")
    with pytest.raises(RequestError, match=f"mine.toml: {complaint}"):
        desk.answer({"do": "add", "model": str(model), "name": "anna"})
    desk.emulator.step()
    assert "anna" not in ask(desk, "truth")["robots"]


@pytest.mark.parametrize(
    ("request_", "complaint"),
    [
        ({}, 'there is no "do": None; choose one of add, '),
        ({"do": "thruth"}, "did you mean truth"),
        ({"do": ["truth"]}, 'there is no "do"'),
        ({"do": "truth", "robot": "hapy"}, "there is no robot 'hapy'; did you mean happy"),
        ({"do": "truth", "robots": "happy"}, 'truth has no key "robots"; did you mean "robot"'),
        ({"do": "faults", "robot": "happy"}, 'faults has no key "robot"; it takes none'),
        ({"do": "truth", "robot": 7}, '"robot" must be text, not 7'),
        ({"do": "pose"}, 'say which "robot": happy, grumpy'),
        ({"do": "pose", "robot": "happy", "x": "1"}, '"x" must be a finite number'),
        ({"do": "pose", "robot": "happy", "x": True}, '"x" must be a finite number'),
        ({"do": "pose", "robot": "happy", "x": math.inf}, '"x" must be a finite number'),
        ({"do": "fault"}, 'fault needs "fault"'),
        ({"do": "fault", "fault": "line-cu"}, "did you mean line-cut"),
        ({"do": "fault", "fault": "line-cut@soon"}, "is not START"),
        ({"do": "clear", "number": 99}, "no fault number 99"),
        ({"do": "speed", "factor": 0}, "must be above zero"),
        ({"do": "speed", "factor": 1e-300}, '"factor" must be from 0.01 to 1000, not 1e-300'),
        ({"do": "speed", "factor": 5e-324}, '"factor" must be from 0.01 to 1000'),
        ({"do": "speed", "factor": 1e300}, '"factor" must be from 0.01 to 1000, not 1e'),
        ({"do": "speed", "factor": math.nan}, '"factor" must be a finite number, not nan'),
        ({"do": "speed", "factor": 10**400}, '"factor" must be a finite number, not 1000'),
        ({"do": "pose", "robot": "happy", "x": 1e300}, "m is too far away; choose one within 100000 m"),
        ({"do": "add", "model": "p3dx", "x": 0.0, "y": -1e6}, "is too far away"),
        ({"do": "joystick", "robot": "happy"}, "happy has no joystick fitted"),
        ({"do": "joystick", "robot": "grumpy", "x": 1.5}, '"x" must be from -1 to 1, not 1.5'),
        ({"do": "joystick", "robot": "grumpy", "throttle": -1}, '"throttle" must be from 0 to 1'),
        ({"do": "add", "model": "p9dx"}, "there is no 'p9dx' among the robots"),
        ({"do": "add", "model": "p3dx", "name": "happy"}, "there is a robot 'happy' already"),
        ({"do": "add", "model": "p3dx", "name": "a/b"}, "robot name 'a/b' will not do"),
        ({"do": "add", "model": "p3dx", "fit": "lasser"}, "there is no part 'lasser'; did you mean laser"),
        ({"do": "add", "model": "p3dx", "x": 1}, 'a place needs "x" and "y"'),
        ({"do": "remove"}, 'remove needs "robot"'),
    ],
)
def test_request_that_cannot_be_met_is_refused_with_what_can(
    desk: ControlRequestHandler, request_: dict[str, Any], complaint: str
) -> None:
    with pytest.raises(RequestError, match=complaint):
        desk.answer(request_)


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=2) | st.dictionaries(st.text(max_size=5), inner, max_size=2),
    max_leaves=4,
)
KEYS = sorted({key for request in REQUESTS.values() for key in request.keys} - {"n", "model"})


HARMLESS = sorted(REQUESTS.keys() - {"quit", "add", "remove"})


@given(do=st.sampled_from(HARMLESS), fields=st.dictionaries(st.sampled_from(KEYS), JSON))
def test_any_request_is_met_or_refused(desk: ControlRequestHandler, do: str, fields: dict[str, Any]) -> None:
    with contextlib.suppress(RequestError):  # the one that is allowed
        json.dumps(desk.answer({"do": do, **fields}), allow_nan=False)

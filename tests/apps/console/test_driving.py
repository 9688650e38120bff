"""One page drives a robot, with the leases; what is old or silent stops it. In virtual time, down to the wheels."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import pytest
from nicegui import Client, ui

from apps.console.driving import DriveCommand, DriveControl
from apps.console.panels.drive import DrivePanel
from apps.console.program import Console
from apps.console.settings import ConsoleSettings
from apps.console.visits import Visit
from bus import keys

if TYPE_CHECKING:
    from tests.agents.components.conftest import Lab, MakeLab

LIMITS = ConsoleSettings.load().drive
STEP = 0.1  # s; how often a browser sends its command
FAST, SLOW = 0.2, 0.01  # m/s


class Drive:
    """Two pages that would drive happy. held: the command that the driver's browser repeats; None when it is silent."""

    def __init__(self, lab: "Lab") -> None:
        self.lab = lab
        self.said: list[str] = []
        self.anna, self.bert = Visit("a", "anna", sockets=1), Visit("b", "bert", sockets=1)
        self.control = lab.do(self._made())
        self.held: tuple[float, float] | None = (0.0, 0.0)
        self.tick = lab.loop.time()
        self.refusal = ""

    async def _made(self) -> DriveControl:
        return DriveControl(self.lab.app, "happy", LIMITS, lambda visit, words: self.said.append(words))

    def take(self, visit: Visit) -> None:
        self.lab.do(self.control.take(visit, ("base", "gripper"), self.lab.loop.time()))
        self.tick = self.lab.loop.time()

    def run(self, seconds: float, *, late: float = 0.0) -> None:
        """Let time pass; the browser sends what it holds, on a line that is so late, s."""
        for _ in range(round(seconds / STEP)):
            if self.held is not None:
                tick = min(self.tick, self.lab.loop.time() - late)
                self.refusal = self.control.drive(self.anna, DriveCommand(tick, *self.held), self.lab.loop.time())
                self.tick = self.lab.loop.time()
            self.lab.do(self.control.check(self.lab.loop.time()))
            self.lab.run(STEP)

    def drives_ahead(self) -> None:
        self.take(self.anna)
        self.held = (0.0, 0.0)
        self.run(0.2)
        self.held = (1.0, 0.0)
        self.run(3.0)
        assert self.speed > FAST, self.refusal

    def is_driven(self) -> bool:
        return self.control.holder is not None

    @property
    def speed(self) -> float:
        return abs(float(self.lab.lockstep.world.truth("happy").linear))


@pytest.fixture
def drive(make_lab: "MakeLab") -> Iterator[Drive]:
    lab = make_lab("gripper")
    lab.until(lambda: {"base", "gripper"} <= lab.elements)
    drive = Drive(lab)
    yield drive
    lab.do(drive.control.close())


def test_only_who_has_control_drives_and_another_page_is_told_who_does(drive: Drive) -> None:
    drive.held = (1.0, 0.0)
    drive.run(0.5)
    assert drive.refusal == "take control first"
    assert drive.speed < SLOW
    drive.drives_ahead()
    drive.take(drive.bert)
    assert drive.said[-1] == "anna drives happy; ask for it to be released"


def test_a_page_whose_session_ends_while_it_takes_control_does_not_get_it(drive: Drive) -> None:
    drive.anna.look_only = "the certificate of operator.anna has expired"
    drive.take(drive.anna)
    assert not drive.is_driven()
    assert drive.said == ["no control of happy: the certificate of operator.anna has expired"]
    drive.take(drive.bert)  # at once: no lease is left behind
    assert drive.control.holder is drive.bert


def test_a_released_key_stops_the_robot_and_leaves_cmd_vel_silent(drive: Drive) -> None:
    drive.drives_ahead()
    heard: list[object] = []
    drive.held = (0.0, 0.0)
    drive.run(0.5)
    subscription = drive.lab.bus.subscribe(keys.CMD_VEL.key("happy"), heard.append)
    drive.run(2.0)
    subscription.close()
    assert drive.speed < SLOW
    assert heard == []  # a stop that somebody else holds can end


def test_a_silent_browser_stops_the_robot_and_loses_the_leases(drive: Drive) -> None:
    drive.drives_ahead()
    drive.held = None
    drive.run(LIMITS.silent_s + 1.5)
    assert drive.speed < SLOW
    assert drive.is_driven()
    drive.run(LIMITS.release_s)
    assert not drive.is_driven()
    assert "has sent nothing" in drive.said[-1]
    assert drive.lab.bus.query(keys.LEASE_STATE.key("happy"), {})[0].value["elements"] == {}


def test_a_browser_that_was_silent_must_let_go_before_it_drives_again(drive: Drive) -> None:
    drive.drives_ahead()
    drive.held = None
    drive.run(1.5)
    drive.held = (1.0, 0.0)
    drive.tick = drive.lab.loop.time()
    drive.run(1.0)
    assert drive.refusal == "let go first: the robot was stopped"
    assert drive.speed < SLOW
    drive.held = (0.0, 0.0)
    drive.run(0.2)
    drive.held = (1.0, 0.0)
    drive.run(3.0)
    assert drive.speed > FAST


def test_commands_that_a_line_delays_for_too_long_stop_the_robot(drive: Drive) -> None:
    drive.drives_ahead()
    drive.run(2.0, late=LIMITS.old_s + 0.1)
    assert "s old and was not obeyed" in drive.refusal
    assert drive.speed < SLOW
    drive.run(1.0, late=LIMITS.old_s - 0.1)
    assert drive.refusal == "let go first: the robot was stopped"


def test_a_driver_must_let_go_after_an_emergency_stop(drive: Drive) -> None:
    drive.drives_ahead()
    drive.control.latch()
    drive.run(1.5)
    assert drive.refusal == "let go first: the robot was stopped"
    assert drive.speed < SLOW


def test_a_page_whose_socket_is_gone_does_not_drive(drive: Drive) -> None:
    drive.drives_ahead()
    drive.anna.sockets, drive.held = 0, None
    drive.run(1.5)
    assert drive.speed < SLOW


@pytest.mark.parametrize("told", [None, 1, "x", [], {}, {"tick": 1.0}, {"tick": "1", "linear": 0, "angular": 0}])
def test_what_is_no_command_is_none(told: object) -> None:
    assert DriveCommand.from_json(told) is None


@pytest.mark.parametrize("value", [float("nan"), float("inf"), 1.01, True, "1", None])
def test_a_speed_that_is_no_part_of_the_chosen_one_is_no_command(value: object) -> None:
    assert DriveCommand.from_json({"tick": 1.0, "linear": value, "angular": 0.0}) is None
    assert DriveCommand.from_json({"tick": 1.0, "linear": 0.5, "angular": -1}) == DriveCommand(1.0, 0.5, -1.0)


def test_the_sliders_of_all_pages_show_the_speeds_and_only_the_driver_sets_them(lab: "Lab", console: Console) -> None:
    drive = console.drive_of("happy")

    def opened(browser: str) -> tuple[Visit, DrivePanel, list[ui.slider]]:
        visit = console.visits.begin(browser)
        visit.robot, visit.sockets = "happy", 1
        with Client(ui.page(f"/{browser}"), request=None) as client:
            panel = DrivePanel(console, visit)
        return visit, panel, [each for each in client.elements.values() if isinstance(each, ui.slider)]

    async def act() -> None:
        (anna, hers, fast), (_, his, slow) = opened("anna"), opened("bert")
        fast[0].set_value(0.6)
        his.refresh()
        assert [slider.value for slider in slow] == list(drive.speeds) == [0.6, LIMITS.angular]
        await drive.take(anna, ("base",), lab.loop.time())
        fast[1].set_value(0.5)
        slow[0].set_value(0.2)  # moved just before the page shows that another one drives
        for panel in (hers, his):
            panel.refresh()
        assert [slider.value for slider in slow] == [slider.value for slider in fast] == [0.6, 0.5]
        assert drive.speeds == (0.6, 0.5)
        assert [slider.enabled for slider in (*fast, *slow)] == [True, True, False, False]
        await drive.release()
        his.refresh()
        assert [slider.enabled for slider in slow] == [True, True]

    lab.do(act())

"""One viewer steers a head, with the lease; a viewer that falls silent stops it. In virtual time, down to the head."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import pytest

from apps.remote_vision.settings import RemoteVisionSettings
from apps.remote_vision.steering import HeadControl
from apps.remote_vision.viewing import Viewing

if TYPE_CHECKING:
    from tests.agents.components.conftest import Lab, MakeLab

LIMITS = RemoteVisionSettings.load().control
STEP = 0.1  # s


class Page:
    """Two viewers of the head of happy."""

    def __init__(self, lab: "Lab") -> None:
        self.lab = lab
        self.said: list[tuple[str, str]] = []
        self.anna, self.bert = Viewing("a", "anna", sockets=1), Viewing("b", "bert", sockets=1)
        self.control = lab.do(self._made())
        self.watching = {self.anna.name, self.bert.name}

    async def _made(self) -> HeadControl:
        return HeadControl(
            self.lab.app, "happy", LIMITS, lambda viewing, words: self.said.append((viewing.name, words))
        )

    @property
    def last(self) -> str:
        """What was said last."""
        return self.said[-1][1] if self.said else ""

    def run(self, seconds: float) -> None:
        """Let time pass; viewers who watch ask for images."""
        for _ in range(round(seconds / STEP)):
            now = self.lab.loop.time()
            for viewing in (self.anna, self.bert):
                if viewing.name in self.watching:
                    viewing.seen_at = now
            self.lab.do(self.control.check(now))
            self.lab.run(STEP)

    def take(self, viewing: Viewing) -> None:
        viewing.seen_at = self.lab.loop.time()
        self.lab.do(self.control.take(viewing))

    def look(self, viewing: Viewing, **place: float) -> None:
        async def look() -> None:
            self.control.look(viewing, place)

        self.lab.do(look())

    @property
    def steers(self) -> str:
        """The name of the viewer who has control."""
        return self.control.holder.name if self.control.holder else ""

    @property
    def pan(self) -> float:
        return float(self.lab.value("ptz", "read")["pan"])

    def is_at_rest(self) -> bool:
        before = self.pan
        self.lab.run(0.5)
        return abs(self.pan - before) < 0.01


@pytest.fixture
def page(make_lab: "MakeLab") -> Iterator[Page]:
    lab = make_lab("ptz:vcc4")
    lab.until(lambda: "ptz" in lab.elements)
    lab.value("ptz", "look", pan=-1.6)
    page = Page(lab)
    yield page
    lab.do(page.control.close())


def test_who_has_control_turns_the_head_and_hears_how_it_ended(page: Page) -> None:
    page.look(page.anna, pan=0.0)
    assert page.last == "the head of happy was not moved: take control first"
    page.take(page.anna)
    assert page.last == "you steer the head of happy"
    page.look(page.anna, pan=-1.0)
    page.run(2.0)
    assert page.pan == pytest.approx(-1.0, abs=0.02)
    assert page.last.startswith("head at pan -57°")


def test_a_second_viewer_is_told_who_steers_and_moves_nothing(page: Page) -> None:
    page.take(page.anna)
    page.take(page.bert)
    assert page.said[-1] == ("bert", "anna steers the head of happy; ask for it to be released")
    page.look(page.bert, pan=1.0)
    page.run(1.0)
    assert page.pan == pytest.approx(-1.6, abs=0.02)
    page.lab.do(page.control.release())
    page.take(page.bert)
    assert page.steers == "bert"


def test_nobody_else_on_the_bus_moves_a_head_that_is_steered(page: Page) -> None:
    page.take(page.anna)
    assert "lease" in page.lab.ask("ptz", "look", pan=1.0).why
    page.lab.do(page.control.release())
    assert page.lab.ask("ptz", "look", pan=-1.5).is_done


def test_a_controller_that_freezes_stops_the_head_at_once_and_loses_control_later(page: Page) -> None:
    page.take(page.anna)
    page.run(0.5)
    page.look(page.anna, pan=1.6)
    page.watching.clear()
    page.run(LIMITS.silent_s + 0.5)
    assert page.is_at_rest()
    assert page.pan < 1.3
    assert page.steers == "anna"
    page.look(page.anna, pan=1.6)
    assert "does not show the image" in page.last
    page.run(LIMITS.release_s)
    assert page.steers == ""
    assert "did not ask for an image" in page.last
    assert page.lab.ask("ptz", "look", pan=0.0).is_done


def test_a_controller_whose_browser_is_closed_stops_the_head(page: Page) -> None:
    page.take(page.anna)
    page.look(page.anna, pan=1.6)
    page.run(0.5)
    page.anna.sockets = 0
    page.run(1.0)
    assert page.is_at_rest()
    assert page.pan < 0.5


def test_of_places_that_come_quickly_the_newest_is_reached(page: Page) -> None:
    page.take(page.anna)
    for pan in (-1.5, -1.4, -1.2, -1.0, -0.8):
        page.look(page.anna, pan=pan)
        page.run(0.1)
    page.run(3.0)
    assert page.pan == pytest.approx(-0.8, abs=0.02)
    assert not any("replaced" in words for _, words in page.said)


def test_stop_stops_it(page: Page) -> None:
    page.take(page.anna)
    page.look(page.anna, pan=1.6)
    page.run(0.5)
    page.lab.do(page.control.stop(page.anna))
    assert page.last == "head stopped"
    assert page.is_at_rest()
    assert page.pan < 0.5


def test_the_gateways_refusal_is_what_the_viewer_reads(page: Page) -> None:
    page.take(page.anna)
    page.look(page.anna, pan=9.0)
    page.run(0.5)
    assert "pan 9 rad is not within" in page.last

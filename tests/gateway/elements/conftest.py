"""One element on a stand: no robot, no driver, only what it sends and announces."""

from collections.abc import Callable
from typing import Any

import pytest

from configs import load
from gateway.elements.element import Element
from gateway.events import Event
from gateway.outbox import Outbox
from gateway.settings import Settings
from p2os import Configuration, Frame, FrameDecoder, ReceivedCommand, RobotModel, StandardSip, decode_command


class Stand:
    """now: steady time, s. announced: the element's events so far."""

    def __init__(self, kind: type[Element[Any]], model: str, settings: Settings) -> None:
        self.now = 10.0
        self.model = load(RobotModel, "robots", model)
        self.announced: list[Event] = []
        self._outbox = Outbox()
        self._ear = FrameDecoder()
        self.element = kind(self._outbox, self.announced.append, settings)

    def has_it(self) -> bool:
        """Whether the element believes that the robot has it."""
        return self.element.is_present

    def connect(self, configuration: Configuration | None = None) -> None:
        self.element.begin_link(self.model, self.now)
        self.element.configure(configuration or Configuration(), self.now)

    def take(self, packet: object) -> None:
        assert type(packet) in self.element.takes
        self.element.take(packet, self.now)

    def see(self, sip: StandardSip) -> None:
        self.element.see(sip, self.now)

    def run(self, seconds: float) -> None:
        """Call the element whenever it asks for it, as the driver does."""
        end = self.now + seconds
        while self.element.deadline <= end:
            self.now = max(self.now, self.element.deadline)
            self.element.watch(self.now)
        self.now = end

    def sent(self) -> list[ReceivedCommand]:
        """Take what the robot hears."""
        heard = []
        while self._outbox.deadline <= 1e9:
            self.now = max(self.now, self._outbox.deadline)
            for frame in self._ear.receive(self._outbox.due(self.now), self.now):
                assert isinstance(frame, Frame)
                heard.append(decode_command(frame.payload))
        return heard


MakeStand = Callable[..., Stand]


@pytest.fixture
def make_stand() -> MakeStand:
    def make(kind: type[Element[Any]], model: str = "p3dx-sh", settings: Settings | None = None) -> Stand:
        return Stand(kind, model, settings or Settings())

    return make

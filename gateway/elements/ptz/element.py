"""The camera head behind AUX1: search, commands, and requests for its position.

A few bytes after every handshake find out which head answers, if any. A head is asked where it looks often while it
moves and seldom while it rests. One that the settings name and that never answers is steered all the same, and where it
looks is reckoned.
"""

from collections.abc import Callable, Sequence
from math import inf

import configs
from gateway.elements.aux_line import AuxExchange, AuxLine
from gateway.elements.element import Element
from gateway.elements.ptz.heads import HEAD_PROTOCOLS, Declined, Direction, HeadProtocol, HeadReply, Zoom
from gateway.elements.ptz.position import HeadPosition, HeadTracker
from gateway.errors import CommandRefused
from gateway.events import Event, HeadSeen
from gateway.outbox import Outbox
from gateway.settings import PtzChoice, Settings
from p2os import AuxData, RobotModel
from p2os.accessories.head_model import HEAD_PORT, HeadKind, HeadModel

MOVING_PERIOD = 0.1
SLOW_LINE_PERIOD = 0.2
RADIO_PERIOD = 0.5
"""Seconds between two questions while the head moves: on a fast line, on one of 9600 bit/s, and over radio modems."""
SLOW_LINE = 9600
RESTING_PERIOD = 2.0
"""Seconds between two questions while it rests."""
TELLING_PERIOD = 1.0
"""Seconds between two reports while it rests."""
BUSY_PERIOD = 0.25
"""Seconds before the command is repeated to a busy head."""
PROBES = 3
"""Times that each kind of head is asked for, since robot or line may drop a frame."""
MOST_MISSED = 3
"""Answers in a row that may fail to come before the head counts as silent."""


class PtzElement(Element[AuxData]):
    """One camera head."""

    takes = (AuxData,)

    def __init__(self, outbox: Outbox, announce: Callable[[Event], None], settings: Settings) -> None:
        super().__init__(outbox, announce, settings)
        self._aux = AuxLine(outbox, self._ask, settings.line.accessory_delay)
        self._candidates: list[HeadProtocol] = []
        self._protocol: HeadProtocol | None = None  # of the head, or of the one that is probed
        self._tracker: HeadTracker | None = None  # of a head that is found
        self._missed = 0
        self._poll_at = self._report_at = inf

    @property
    def faults(self) -> Sequence[str]:
        """A head that was found does not answer any more."""
        return ("the camera head does not answer",) if self._missed >= MOST_MISSED else ()

    @property
    def model(self) -> HeadModel:
        """The model of a head that is present."""
        assert self._protocol is not None  # found
        return self._protocol.model

    def begin_link(self, model: RobotModel, now: float) -> None:
        """Search for the head: the former one, the one that the settings name, or any."""
        choice = self._settings.fitted.ptz
        kinds: Sequence[HeadKind] = [kind for kind in HeadKind if choice in (PtzChoice.AUTO, kind.value)]
        if self.is_present and self._protocol is not None:
            kinds = [self._protocol.kind]
        talks = [HEAD_PROTOCOLS[kind](configs.load(HeadModel, "accessories", kind.value)) for kind in kinds]
        self._candidates = talks * PROBES
        self._try_next(now)
        self.watch(now)

    def lose_link(self) -> None:
        """Forget what was under way."""
        self._aux.clear()
        self._candidates.clear()
        self._tracker = None
        self._missed = 0
        self.deadline = self._poll_at = self._report_at = inf

    def look(self, pan: float | None, tilt: float | None, zoom: float | None, now: float) -> None:
        """Turn and zoom; None leaves an axis as it is.

        Raises:
            CommandRefused: Something is beyond the limits, nothing is given, or the head is still being looked for.
        """
        if pan is None and tilt is None and zoom is None:
            raise CommandRefused('ptz needs pan, tilt or zoom, or {"do": "stop"}')
        model = self.model
        _check("pan", pan, model.pan.limits, " rad")
        _check("tilt", tilt, model.tilt.limits, " rad")
        _check("zoom", zoom, (1.0, model.lens.ratio), "")
        protocol, tracker = self._found()
        goal = tracker.changed(pan, tilt, zoom)
        if pan is not None or tilt is not None:
            self._aux.put("turn", protocol.turn(goal.pan, goal.tilt))
        if zoom is not None:
            self._aux.put("zoom", protocol.zoom(goal.zoom))
        tracker.send(goal, now)
        self._hurry(now)

    def stop(self, now: float) -> None:
        """Stop where it is.

        Raises:
            CommandRefused: The head is still being looked for.
        """
        protocol, tracker = self._found()
        self._aux.drop(lambda name: name in ("turn", "zoom", "again"))
        for number, exchange in enumerate(protocol.stop):
            self._aux.put(f"stop {number}", exchange)
        tracker.stop(now)
        self._hurry(now)

    def duration(self, pan: float | None, tilt: float | None, zoom: float | None) -> float:
        """Return the expected duration of a motion, s; None leaves an axis as it is."""
        return 0.0 if self._tracker is None else self._tracker.travel_time(pan, tilt, zoom)

    def is_moving(self, now: float) -> bool:
        """Return whether it moves, as far as is known."""
        return self._tracker is not None and self._tracker.is_moving(now)

    def halt(self, now: float) -> None:
        """Stop where it is, if it moves to a goal."""
        tracker = self._tracker
        if tracker is not None and tracker.is_moving(now) and (tracker.turns or tracker.zooms):
            self.stop(now)

    def take(self, packet: AuxData, now: float) -> None:
        """Take bytes from the head."""
        if packet.port != HEAD_PORT or self._protocol is None or self._aux.current is None:
            return
        heard = self._protocol.hear(packet.data)
        if heard:
            exchange = self._aux.finish()
            assert exchange is not None  # there was one
            self._missed = 0
            for each in heard:
                self._note(each, exchange, now)
        else:
            self._aux.fetch_rest(self._protocol.pending)
        self.watch(now)

    def watch(self, now: float) -> None:
        """Do what is due: a request, the next exchange, a report."""
        if now >= self._poll_at:
            self._poll(now)
        if self._aux.watch(now):
            self._miss(now)
            self._aux.watch(now)
        if now >= self._report_at:
            self._report(now)
        self.deadline = min(self._aux.deadline, self._poll_at, self._report_at)

    # Finding it.

    def _found(self) -> tuple[HeadProtocol, HeadTracker]:
        if self._protocol is None or self._tracker is None:
            raise CommandRefused("the camera head has not answered yet; try again")
        return self._protocol, self._tracker

    def _try_next(self, now: float) -> None:
        """Ask the next kind of head; with none left, steer the one that the settings name, or rest.

        One that answered before is looked for all the time: its power may come back.
        """
        if self._candidates:
            self._protocol = self._candidates.pop(0)
            self._aux.put("probe", self._protocol.probe)
        elif self._protocol is not None and self._settings.fitted.ptz == self._protocol.kind.value:
            self._aux.is_one_way = True
            self._meet(now).reckon(now)
            self._start(now)
        elif self._protocol is not None and self.is_present:
            self._missed = MOST_MISSED
            self._aux.put_back(self._protocol.probe, now + RESTING_PERIOD)

    def _meet(self, now: float) -> HeadTracker:
        self.is_present = True
        self._tracker = HeadTracker(self.model)
        self._report_at = now
        self._poll_at = inf if self._aux.is_one_way else now
        return self._tracker

    def _start(self, now: float) -> None:
        """Make it obey; it looks for its zero meanwhile."""
        protocol, tracker = self._found()
        for number, exchange in enumerate(protocol.start):
            self._aux.put(f"start {number}", exchange)
        tracker.expect(protocol.model.power_on_s + protocol.model.initialise_s, now)
        self._hurry(now)

    # Talking.

    def _miss(self, now: float) -> None:
        """Note that an answer is missing."""
        if self._tracker is None:
            self._try_next(now)
        else:
            self._missed += 1

    def _note(self, heard: HeadReply, exchange: AuxExchange, now: float) -> None:
        tracker = self._tracker
        if tracker is None:
            tracker = self._meet(now)
            if isinstance(heard, Direction):  # it obeys already, and a start would turn it
                tracker.send(HeadPosition(heard.pan, heard.tilt), now)
            else:
                self._start(now)
        match heard:
            case Direction(pan, tilt):
                self._see(tracker, HeadPosition(pan, tilt, tracker.now(now).zoom), now)
            case Zoom(ratio):
                self._see(tracker, tracker.now(now)._replace(zoom=ratio), now)
            case Declined(is_busy=True):
                self._aux.put_back(exchange, now + BUSY_PERIOD)
                tracker.postpone(now + BUSY_PERIOD)
            case Declined(is_asleep=True) if not self._aux.has("start 0"):
                self._start(now)

    def _poll(self, now: float) -> None:
        protocol, tracker = self._found()
        is_moving = tracker.is_moving(now)
        self._poll_at = now + (self._moving_period if is_moving else RESTING_PERIOD)
        if tracker.turns or not tracker.zooms:
            self._aux.put("direction", protocol.ask_direction)
        if tracker.zooms or not is_moving:
            self._aux.put("zoom position", protocol.ask_zoom)

    @property
    def _moving_period(self) -> float:
        if not self._settings.line.streams:
            return RADIO_PERIOD
        return SLOW_LINE_PERIOD if 0 < self._outbox.baud <= SLOW_LINE else MOVING_PERIOD

    # Telling.

    def _hurry(self, now: float) -> None:
        """Request the direction and report at once, after a command."""
        if not self._aux.is_one_way:
            self._poll_at = now
        self._report_at = now
        self.watch(now)

    def _see(self, tracker: HeadTracker, seen: HeadPosition, now: float) -> None:
        was_moving = tracker.is_moving(now)
        if tracker.see(seen, now) or was_moving:
            self._report_at = now
        if was_moving and not tracker.is_moving(now):
            self._poll_at = now + RESTING_PERIOD

    def _report(self, now: float) -> None:
        _, tracker = self._found()
        is_moving = tracker.is_moving(now)
        self._report_at = now + (MOVING_PERIOD if is_moving and self._aux.is_one_way else TELLING_PERIOD)
        self._announce(HeadSeen(*tracker.now(now), is_moving))


def _check(name: str, value: float | None, limits: tuple[float, float], unit: str) -> None:
    lowest, highest = limits
    if value is not None and not lowest <= value <= highest:
        raise CommandRefused(f"{name} {value:g}{unit} is not within {lowest:.3f} to {highest:.3f}{unit}")

"""The camera head behind AUX1: found by asking, steered, and asked where it looks.

A few bytes after every handshake find out which head answers, if any. A head is asked where it looks often while it
moves and seldom while it rests. One that the settings name and that never answers is steered all the same, and where it
looks is reckoned.
"""

from collections.abc import Callable, Mapping, Sequence
from math import inf

import configs
from gateway.elements.aux_line import AuxExchange, AuxLine
from gateway.elements.element import Element
from gateway.elements.ptz.heads import Declined, Direction, HeadTalk, Heard, Vcc4Talk, ViscaTalk, Zoom
from gateway.elements.ptz.position import HeadPlace, HeadPosition
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
"""Seconds before a busy head is told again."""
PROBES = 3
"""Times that each kind of head is asked for, since robot or line may drop a frame."""
MOST_MISSED = 3
"""Answers in a row that may fail to come before the head counts as silent."""

_TALKS: Mapping[HeadKind, Callable[[HeadModel], HeadTalk]] = {HeadKind.VCC4: Vcc4Talk, HeadKind.EVID30: ViscaTalk}


class PtzElement(Element):
    """One camera head."""

    takes = (AuxData,)

    def __init__(self, outbox: Outbox, announce: Callable[[Event], None], settings: Settings) -> None:
        super().__init__(outbox, announce, settings)
        self._aux = AuxLine(outbox, self._ask, settings.line.detour)
        self._candidates: list[HeadTalk] = []
        self._talk: HeadTalk | None = None  # whom one talks to, or asks whether it is there
        self._place: HeadPlace | None = None  # of a head that is found
        self._missed = 0
        self._poll_at = self._tell_at = inf

    @property
    def faults(self) -> Sequence[str]:
        """It answered before, and does no more."""
        return ("the camera head does not answer",) if self._missed >= MOST_MISSED else ()

    @property
    def model(self) -> HeadModel:
        """What head it is; only of one that is present."""
        assert self._talk is not None  # found
        return self._talk.model

    def begin_link(self, model: RobotModel, now: float) -> None:
        """Look for the head: the one that was there before, the one that the settings name, or any."""
        choice = self._settings.fitted.ptz
        kinds: Sequence[HeadKind] = [kind for kind in HeadKind if choice in (PtzChoice.AUTO, kind.value)]
        if self.is_present and self._talk is not None:
            kinds = [self._talk.kind]
        talks = [_TALKS[kind](configs.load(HeadModel, "accessories", kind.value)) for kind in kinds]
        self._candidates = talks * PROBES
        self._try_next(now)
        self.watch(now)

    def lose_link(self) -> None:
        """Forget what was under way."""
        self._aux.clear()
        self._candidates.clear()
        self._place = None
        self._missed = 0
        self.deadline = self._poll_at = self._tell_at = inf

    def look(self, pan: float | None, tilt: float | None, zoom: float | None, now: float) -> None:
        """Look somewhere; what is None stays as it is.

        Raises:
            CommandRefused: Something is beyond the limits, nothing is given, or the head is still being looked for.
        """
        if pan is None and tilt is None and zoom is None:
            raise CommandRefused('ptz needs pan, tilt or zoom, or {"do": "stop"}')
        model = self.model
        _check("pan", pan, model.pan.limits, " rad")
        _check("tilt", tilt, model.tilt.limits, " rad")
        _check("zoom", zoom, (1.0, model.lens.ratio), "")
        talk, place = self._found()
        goal = place.changed(pan, tilt, zoom)
        if pan is not None or tilt is not None:
            self._aux.put("turn", talk.turn(goal.pan, goal.tilt))
        if zoom is not None:
            self._aux.put("zoom", talk.zoom(goal.zoom))
        place.send(goal, now)
        self._hurry(now)

    def stop(self, now: float) -> None:
        """Stop where it is.

        Raises:
            CommandRefused: The head is still being looked for.
        """
        talk, place = self._found()
        self._aux.drop(lambda name: name in ("turn", "zoom", "again"))
        for number, exchange in enumerate(talk.stop):
            self._aux.put(f"stop {number}", exchange)
        place.stop(now)
        self._hurry(now)

    def duration(self, pan: float | None, tilt: float | None, zoom: float | None) -> float:
        """Expected duration until it looks somewhere, s; what is None stays as it is."""
        return 0.0 if self._place is None else self._place.travel_time(pan, tilt, zoom)

    def is_moving(self, now: float) -> bool:
        """It is on its way, as far as one knows."""
        return self._place is not None and self._place.is_moving(now)

    def halt(self, now: float) -> None:
        """Stop where it is, if it is on its way to where it was told to look."""
        place = self._place
        if place is not None and place.is_moving(now) and (place.turns or place.zooms):
            self.stop(now)

    def take(self, packet: object, now: float) -> None:
        """Bytes from the head."""
        assert isinstance(packet, AuxData)
        if packet.port != HEAD_PORT or self._talk is None or self._aux.current is None:
            return
        heard = self._talk.hear(packet.data)
        if heard:
            exchange = self._aux.finish()
            assert exchange is not None  # there was one
            self._missed = 0
            for each in heard:
                self._note(each, exchange, now)
        else:
            self._aux.fetch_rest(self._talk.pending)
        self.watch(now)

    def watch(self, now: float) -> None:
        """See to what is due: a question, the next exchange, a report."""
        if now >= self._poll_at:
            self._poll(now)
        if self._aux.watch(now):
            self._miss(now)
            self._aux.watch(now)
        if now >= self._tell_at:
            self._tell(now)
        self.deadline = min(self._aux.deadline, self._poll_at, self._tell_at)

    # Finding it.

    def _found(self) -> tuple[HeadTalk, HeadPlace]:
        if self._talk is None or self._place is None:
            raise CommandRefused("the camera head has not answered yet; try again")
        return self._talk, self._place

    def _try_next(self, now: float) -> None:
        """Ask the next kind of head; with none left, steer the one that the settings name, or rest.

        One that answered before is looked for all the time: its power may come back.
        """
        if self._candidates:
            self._talk = self._candidates.pop(0)
            self._aux.put("probe", self._talk.probe)
        elif self._talk is not None and self._settings.fitted.ptz == self._talk.kind.value:
            self._aux.is_blind = True
            self._meet(now).reckon(now)
            self._start(now)
        elif self._talk is not None and self.is_present:
            self._missed = MOST_MISSED
            self._aux.put_back(self._talk.probe, now + RESTING_PERIOD)

    def _meet(self, now: float) -> HeadPlace:
        self.is_present = True
        self._place = HeadPlace(self.model)
        self._tell_at = now
        self._poll_at = inf if self._aux.is_blind else now
        return self._place

    def _start(self, now: float) -> None:
        """Make it obey; it looks for its zero meanwhile."""
        talk, place = self._found()
        for number, exchange in enumerate(talk.start):
            self._aux.put(f"start {number}", exchange)
        place.expect(talk.model.power_on_s + talk.model.initialise_s, now)
        self._hurry(now)

    # Talking.

    def _miss(self, now: float) -> None:
        """No answer came."""
        if self._place is None:
            self._try_next(now)
        else:
            self._missed += 1

    def _note(self, heard: Heard, exchange: AuxExchange, now: float) -> None:
        place = self._place
        if place is None:
            place = self._meet(now)
            if isinstance(heard, Direction):  # it obeys already, and a start would turn it
                place.send(HeadPosition(heard.pan, heard.tilt), now)
            else:
                self._start(now)
        match heard:
            case Direction(pan, tilt):
                self._see(place, HeadPosition(pan, tilt, place.now(now).zoom), now)
            case Zoom(ratio):
                self._see(place, place.now(now)._replace(zoom=ratio), now)
            case Declined(is_busy=True):
                self._aux.put_back(exchange, now + BUSY_PERIOD)
                place.postpone(now + BUSY_PERIOD)
            case Declined(is_asleep=True) if not self._aux.has("start 0"):
                self._start(now)

    def _poll(self, now: float) -> None:
        talk, place = self._found()
        is_moving = place.is_moving(now)
        self._poll_at = now + (self._moving_period if is_moving else RESTING_PERIOD)
        if place.turns or not place.zooms:
            self._aux.put("direction", talk.ask_direction)
        if place.zooms or not is_moving:
            self._aux.put("zoom position", talk.ask_zoom)

    @property
    def _moving_period(self) -> float:
        if not self._settings.line.streams:
            return RADIO_PERIOD
        return SLOW_LINE_PERIOD if 0 < self._outbox.baud <= SLOW_LINE else MOVING_PERIOD

    # Telling.

    def _hurry(self, now: float) -> None:
        """Something has been sent: what is due is due now."""
        if not self._aux.is_blind:
            self._poll_at = now
        self._tell_at = now
        self.watch(now)

    def _see(self, place: HeadPlace, seen: HeadPosition, now: float) -> None:
        was_moving = place.is_moving(now)
        if place.see(seen, now) or was_moving:
            self._tell_at = now
        if was_moving and not place.is_moving(now):
            self._poll_at = now + RESTING_PERIOD

    def _tell(self, now: float) -> None:
        _, place = self._found()
        is_moving = place.is_moving(now)
        self._tell_at = now + (MOVING_PERIOD if is_moving and self._aux.is_blind else TELLING_PERIOD)
        self._announce(HeadSeen(*place.now(now), is_moving))


def _check(name: str, value: float | None, limits: tuple[float, float], unit: str) -> None:
    lowest, highest = limits
    if value is not None and not lowest <= value <= highest:
        raise CommandRefused(f"{name} {value:g}{unit} is not within {lowest:.3f} to {highest:.3f}{unit}")

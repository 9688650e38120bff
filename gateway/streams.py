"""Publishers of one robot: from the driver's events and from time to messages on its keys."""

import logging
import threading
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from operator import is_
from typing import Any, ParamSpec

from bus import Bus, BusUnavailable, Publisher, Subscription, keys
from bus.keys import Topic
from bus.messages import TFMessage
from gateway.elements.adapter import BusAdapter, RobotContext
from gateway.events import (
    ChargeSeen,
    Event,
    LinkLost,
    MotionEnded,
    SipReceived,
)
from gateway.health import RobotHealth
from gateway.telemetry import Telemetry
from p2os import Encoders, IoReport, StandardSip

P = ParamSpec("P")
log = logging.getLogger("gateway")

PERIOD = 1.0
"""Seconds between two of what is published at 1 Hz."""
STREAMS = (
    keys.ODOM,
    keys.TF,
    keys.SONAR,
    keys.SONAR_POINTS,
    keys.BUMPERS,
    keys.BATTERY,
    keys.STATE,
    keys.IO,
    keys.JOINT_STATES,
    keys.TF_STATIC,
    keys.DIAGNOSTICS,
)


class RobotPublishers(Subscription):
    """One robot's publishers.

    A message is made only if a program subscribes to its key. An error in making or writing it costs this message only:
    it is counted, and logged at its first occurrence.

    due_at: when something is to be published even if nothing happens, s.
    unpublished: messages lost to errors, counted by stream and kind of error.
    """

    def __init__(self, robot: RobotContext, bus: Bus, adapters: Sequence[BusAdapter[Any]]) -> None:
        self._name = robot.name
        self._bus = bus
        self._driver = robot.driver
        self._telemetry = Telemetry(robot.name, robot.model)
        self._adapters = adapters
        self._takers: dict[type, list[BusAdapter[Any]]] = {}  # on the robot's line, by the class of the event
        for adapter in adapters:
            if adapter.cable is None:
                for kind in adapter.events:
                    self._takers.setdefault(kind, []).append(adapter)
        cables = [adapter.cable for adapter in adapters if adapter.cable is not None]
        self._health = RobotHealth(robot.name, robot.driver, cables)
        self._sip: StandardSip | None = None
        self._has_io_packets = False
        self._battery_shown: tuple[float, int | None, bool] | None = None
        self._ports_shown: tuple[int, int] | None = None
        self._state_shown: tuple[Any, ...] | None = None
        self._judged: tuple[Any, ...] = (None,) * 5  # what the faults were last looked for in
        self._streams: Mapping[Topic, Publisher] = {
            topic: bus.publisher(topic.key(robot.name), topic.type_name) for topic in STREAMS
        }
        self._adapter_streams: dict[Topic, Publisher] = {}  # declared when they are first needed
        self.unpublished: Counter[str] = Counter()
        self._declaring = threading.Lock()  # elements on cables of their own publish on threads of their own
        self.due_at = 0.0

    def publish(self, event: Event, stamp: int) -> None:
        """Publish what follows from an event of the robot's line. stamp: wall clock when its last byte came, ns."""
        for adapter in self._takers.get(type(event), ()):
            self.publish_element(adapter, event, stamp)
        telemetry = self._telemetry
        match event:
            case SipReceived():
                self._publish_sip(event, stamp)
            case ChargeSeen(fraction):
                telemetry.note_charge(fraction)
            case Encoders():
                telemetry.note_ticks(event)
                self._publish(keys.JOINT_STATES, telemetry.joints, stamp)
            case IoReport():
                self._has_io_packets = True
                self._publish(keys.IO, telemetry.inputs_outputs, event, stamp)
            case MotionEnded(motion_id):
                with self.guarded(keys.RESULT.suffix):
                    self._bus.put(keys.RESULT.key(self._name, motion_id), dict(event.as_json()))
            case LinkLost():
                self._sip = None
                self._has_io_packets = False
                telemetry.forget_ticks()

    def publish_element(self, adapter: BusAdapter[Any], event: Event, stamp: int) -> None:
        """Publish what follows for one element from an event of its line; from any thread. stamp: as in `publish`."""
        if isinstance(event, adapter.events) and self.is_wanted(adapter):
            with self.guarded(adapter.name):
                for topic, message in adapter.messages(event, stamp):
                    with self.guarded(topic.suffix):
                        self._stream(topic).put(message)

    @contextmanager
    def guarded(self, stream: str) -> Iterator[None]:
        """Count and log what a publisher raises: one bad value must not end the gateway, nor a cable's thread.

        Raises:
            BusUnavailable: The bus is closed, and nothing can be published any more.
        """
        try:
            yield
        except BusUnavailable:
            raise
        except Exception as error:  # of any kind, since the value that caused it may have come from anyone
            self._count_error(stream, error)

    def _count_error(self, stream: str, error: Exception) -> None:
        reason = f"{stream}: {type(error).__name__}"
        if not self.unpublished[reason]:
            log.exception("a message on %s was not published; others follow", stream)
        self.unpublished[reason] += 1

    def _publish(self, topic: Topic, make: Callable[P, object], *args: P.args, **kwargs: P.kwargs) -> None:
        """Make a message and publish it, if anybody subscribes to it."""
        publisher = self._streams[topic]
        if publisher.has_listeners:
            try:  # as in `guarded`, which takes longer than a short message
                publisher.put(make(*args, **kwargs))
            except BusUnavailable:
                raise
            except Exception as error:  # of any kind: as in `guarded`
                self._count_error(topic.suffix, error)

    def _publish_sip(self, event: SipReceived, stamp: int) -> None:
        telemetry, sip = self._telemetry, event.sip
        self._sip = sip
        telemetry.note_wheels(sip)
        self._publish(keys.ODOM, telemetry.odometry, event, stamp)
        self._publish(keys.TF, telemetry.transform, event, stamp)
        self._publish(keys.SONAR, telemetry.sonar, sip, stamp)
        self._publish(keys.SONAR_POINTS, telemetry.sonar_points, sip, stamp)
        self._publish(keys.BUMPERS, telemetry.bumpers, sip, stamp)
        if (sip.best_battery, sip.charge_state, sip.charger_good) != self._battery_shown:
            self._publish_battery(sip, stamp)
        if (sip.digital_in, sip.digital_out) != self._ports_shown:
            self._publish_user_ports(sip, stamp)

    def _publish_battery(self, sip: StandardSip, stamp: int) -> None:
        self._battery_shown = sip.best_battery, sip.charge_state, sip.charger_good
        self._publish(keys.BATTERY, self._telemetry.battery, sip, stamp)

    def _publish_user_ports(self, sip: StandardSip, stamp: int) -> None:
        if not self._has_io_packets:
            self._ports_shown = sip.digital_in, sip.digital_out
            self._publish(keys.IO, self._telemetry.user_ports, sip, stamp)

    def publish_status(self, refused: Mapping[str, int], refusal: str | None, now: float, stamp: int) -> None:
        """Publish the state if it has changed, and everything that is due at 1 Hz.

        Args:
            refused: Commands not obeyed, counted by what they were.
            refusal: The latest of them, if it was just now.
            now: Steady time, s.
            stamp: Wall clock, ns.
        """
        is_due = now >= self.due_at
        driver = self._driver
        inputs = self._sip, driver.is_connected, driver.is_estopped, refusal, driver.link_problem
        if not is_due and all(map(is_, inputs, self._judged)):
            return  # nothing has changed that faults follow from
        self._judged = inputs
        found = self._health.faults(self._sip, refusal)
        shown = self._driver.is_connected, self._driver.is_estopped, self._sip and self._sip.flags, tuple(found)
        if is_due or shown != self._state_shown:
            self._state_shown = shown
            self._publish(keys.STATE, self._health.state, self._sip, found, stamp)
        if is_due:
            self.due_at = now + PERIOD
            self._publish(keys.TF_STATIC, self._static_transforms, stamp)
            self._publish(keys.DIAGNOSTICS, self._health.diagnostics, found, refused, self.unpublished, stamp)
            if self._sip is not None:
                self._publish_battery(self._sip, stamp)
                self._publish_user_ports(self._sip, stamp)

    def _static_transforms(self, stamp: int) -> TFMessage:
        transforms = self._telemetry.static_transforms(stamp)
        for adapter in self._adapters:
            transforms.transforms.extend(adapter.transforms(stamp))
        return transforms

    def is_wanted(self, adapter: BusAdapter[Any]) -> bool:
        """Return whether anybody subscribes to a stream of an element now; from any thread."""
        with suppress(BusUnavailable):  # it is being closed
            return any(self._stream(topic).has_listeners for topic in adapter.streams)
        return False

    def _stream(self, topic: Topic) -> Publisher:
        known = self._streams.get(topic) or self._adapter_streams.get(topic)
        if known is not None:
            return known
        with self._declaring:
            if topic not in self._adapter_streams:
                self._adapter_streams[topic] = self._bus.publisher(topic.key(self._name), topic.type_name)
            return self._adapter_streams[topic]

    def close(self) -> None:
        """Withdraw the publishers."""
        for publisher in (*self._streams.values(), *self._adapter_streams.values()):
            publisher.close()

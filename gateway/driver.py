"""The driver of one robot: bytes and time in, events and bytes out. No port, no clock, no threads.

The owner of the port calls `receive` with the bytes read, writes those of `bytes_due` at the rate `baud`, and calls
again at `deadline` at the latest. Commands may be called in between; their bytes are due at once.

A call later than `LONGEST_SILENCE` after the one before means that this process was frozen, or the computer asleep: the
robot's watchdog has stopped it, and any packet would make it move again. So the driver begins again with STOP and
CLOSE, and refuses commands that may have waited meanwhile.
"""

import random
from collections import Counter
from collections.abc import Callable, Sequence
from math import inf
from typing import Any

from gateway.accelerations import acceleration_frames, known_accelerations, speed_frames, travel_time
from gateway.connector import CLOSE, STOP, Connector
from gateway.elements.element import Element
from gateway.elements.gyro.element import Gyro
from gateway.elements.standard.element import ControllerConfiguration
from gateway.errors import CommandRefused, ExitCode, GatewayError
from gateway.events import (
    Event,
    HandshakeCompleted,
    LinkLost,
    RobotRejected,
    SipReceived,
)
from gateway.link_diagnosis import LinkDiagnosis, LinkProblem
from gateway.motion_in_progress import is_at_rest
from gateway.plausibility import Plausibility
from gateway.rate_raiser import RateRaiser
from gateway.robot_commands import RobotCommands
from gateway.settings import Settings
from p2os import (
    SIMULATOR_NAMES,
    SIMULATOR_SERIAL,
    Command,
    Configuration,
    Damaged,
    DecodeError,
    FrameDecoder,
    Identity,
    PacketType,
    RobotModel,
    SipCodec,
    StandardSip,
    decode_packet,
    encode_command,
)

LONGEST_SILENCE = 0.5
"""Seconds between two calls after which the driver connects again, and for as long refuses commands of unknown age."""
ModelFinder = Callable[[Identity], RobotModel]
"""Says which model a robot is; raises GatewayError."""


class Driver(RobotCommands):
    """The driver of one robot; its commands are in `RobotCommands`.

    identity, model, configuration: of the robot, once known; they stay after it is lost. damaged: bytes that were no
    frame, counted by reason. implausible: SIPs refused, likewise. lost: how often the link was lost, by reason.
    link_problem: why no robot is connected, after some seconds without one.
    """

    def __init__(
        self,
        find_model: ModelFinder,
        rates: Sequence[int],
        settings: Settings | None = None,
        rng: random.Random | None = None,
        probe_rates: Sequence[int] = (),
    ) -> None:
        super().__init__(settings or Settings())
        self._find_model = find_model
        self._line = self._settings.line
        self._connector = Connector(rates, self._outbox, rng or random.Random(), self._line, probe_rates)
        self._diagnosis = LinkDiagnosis()
        wanted_rate = None if self._settings.radio else self._settings.raise_baud_to
        self._rate_raiser = RateRaiser(self._outbox, self._connector, wanted_rate)
        self._decoder = FrameDecoder()
        self._codec: SipCodec | None = None
        self._plausibility: Plausibility | None = None
        self._takers: dict[type, list[Element[Any]]] = {}
        for element in self._elements.values():
            for packet in element.takes:
                self._takers.setdefault(packet, []).append(element)
        self.has_port = False
        self._is_open = False  # the handshake is over: OPEN is sent
        self._sip_at = -inf  # or when OPEN was queued
        self._last_run: float | None = None
        self._deaf_until = -inf
        self.identity: Identity | None = None
        self.model: RobotModel | None = None
        self.configuration: Configuration | None = None
        self.damaged: Counter[str] = Counter()
        self.implausible: Counter[str] = Counter()
        self.lost: Counter[str] = Counter()
        self.link_problem: LinkProblem | None = None

    @property
    def accelerations(self) -> dict[str, float] | None:
        """The robot's accelerations, m/s² and rad/s²; None while its own report may still come."""
        if self.model is None or (self.configuration is None and self.lookup(ControllerConfiguration).is_awaited):
            return None
        return known_accelerations(self._settings.limits, self.model, self.configuration)

    def time_to_move(self, distance: float) -> float:
        """Return the expected duration of a `move` over a distance in m, s."""
        return self._travel_time(distance, self.max_linear, "acceleration", "deceleration")

    def time_to_turn(self, angle: float) -> float:
        """Return the expected duration of a `turn` by an angle in rad, s."""
        return self._travel_time(angle, self.max_angular, "angular_acceleration", "angular_deceleration")

    # The port's side.

    @property
    def baud(self) -> int:
        """The rate for writing the bytes due and for reading from now on, bit/s; 0 for a line without a rate."""
        return self._connector.baud

    @property
    def deadline(self) -> float:
        """When to call `receive` and `bytes_due` again even without bytes, s."""
        if not self.has_port:
            return inf
        if not self._is_open:
            return min(self._outbox.deadline, self._connector.deadline)
        return min(
            self._outbox.deadline,
            self._motion.deadline,
            self._rate_raiser.deadline,
            self._sip_at + self._line.sip_timeout,
            *(element.deadline for element in self._elements.values()),
        )

    @property
    def stopping_bytes(self) -> bytes:
        """The bytes that stop the robot; written first on closing."""
        return STOP

    @property
    def closing_bytes(self) -> bytes:
        """The bytes to write once the robot stands: CLOSE switches the motors off, and a moving robot would coast."""
        return CLOSE

    def port_opened(self, now: float) -> None:
        """Begin: the port is open."""
        self._last_run = now
        self.has_port = True
        self._diagnosis.begin(now)
        self._begin(now, is_new_connection=True)

    def port_lost(self, reason: str, now: float) -> None:
        """Note that the port is lost or cannot be opened again, and why.

        `receive` still reports what follows from it.
        """
        self._last_run = now
        self._diagnosis.begin(now)
        if not self.has_port:
            self._diagnosis.note_no_port(reason)
        elif not self._is_open and self._connector.is_searching:
            self._connector.lose_line()
            self._diagnosis.note_hang_up(reason, now)
        self.has_port = False
        self._lose(reason, now)

    def receive(self, data: bytes, now: float) -> list[Event]:
        """Take bytes as read; none lets time pass.

        Args:
            data: Bytes from the line.
            now: Steady time, s.
        Returns:
            What happened, commands given since the last call included.
        """
        if self._wake(now):
            data = b""  # of unknown age
        if not self._is_open:
            self._connector.hear(data, now)
        for found in self._decoder.receive(data, now):
            if not isinstance(found, Damaged):
                self._take(found.payload, now)
            elif self._is_open:
                self.damaged[found.reason.value] += 1
        self._watch(now)
        self.link_problem = self._diagnosis.problem(now)
        events = self._events[:]
        self._events.clear()
        return events

    def bytes_due(self, now: float) -> bytes:
        """Take what must be written now; one frame, or nothing."""
        self._wake(now)
        return self._outbox.due(now) if self.has_port else b""

    # Inside.

    def _check_link(self, now: float) -> None:
        self._wake(now)
        if not self.is_connected:
            raise CommandRefused("the robot is not connected; the gateway goes on looking for it")
        if now < self._deaf_until:
            raise CommandRefused("the gateway has just been frozen and does not know how old this command is")

    def _wake(self, now: float) -> bool:
        """Detect that the last call is too long ago; return whether the connection begins again."""
        silence = 0.0 if self._last_run is None else now - self._last_run
        self._last_run = now
        if silence <= LONGEST_SILENCE or not self.has_port:
            return False
        self._deaf_until = now + LONGEST_SILENCE
        self._lose("the gateway itself was frozen", now)
        self._begin(now)
        return True

    def _begin(self, now: float, *, is_new_connection: bool = False) -> None:
        self._decoder = FrameDecoder()
        self._connector.begin(now, is_new_connection=is_new_connection)

    def _lose(self, reason: str, now: float) -> None:
        """Give up the robot, not the port."""
        if self._is_open:
            self.lost[reason] += 1
            self._motion.lose_link()
            self._rate_raiser.lose_link()
            for element in self._elements.values():
                element.lose_link()
            if self.is_connected:
                self._events.append(LinkLost(reason))
        self._diagnosis.begin(now)
        self._is_open = self.is_connected = False
        self._outbox.clear()

    def _restart(self, reason: str, now: float) -> None:
        self._lose(reason, now)
        self._begin(now)

    def _watch(self, now: float) -> None:
        if not self.has_port:
            return
        if not self._is_open:
            failed = self._connector.watch(now)
            if failed is not None:
                self._events.append(failed)
                self._diagnosis.note_sweep(failed, now)
            elif self._diagnosis.is_due(now):
                self._diagnosis.note_sweep(self._connector.so_far, now)
        elif now - self._sip_at >= self._line.sip_timeout:
            if not self.is_connected:
                self._diagnosis.note_silence(now)
            self._restart("the robot fell silent", now)
        else:
            self._motion.watch(now)
            self._rate_raiser.watch(now)
            for element in self._elements.values():
                if now >= element.deadline:
                    element.watch(now)

    def _take(self, payload: bytes, now: float) -> None:
        if not self._is_open:
            identity = self._connector.receive(payload, now)
            if identity is not None:
                self._meet(identity, now)
        elif payload[0] in (PacketType.RESET, PacketType.RESET_WITH_DATA):
            self._restart("the controller was reset", now)
        elif self.is_connected and payload == bytes([PacketType.SYNC0]):
            self._restart("the robot fell back into the handshake", now)
        else:
            self._read(payload, now)

    def _meet(self, identity: Identity, now: float) -> None:
        """Open and configure the robot that has identified itself, if this gateway serves it."""
        try:
            if self.identity is not None and identity != self.identity:
                raise GatewayError(
                    f"another robot answers, {identity.name} ({identity.subtype}) in place of {self.identity.name} "
                    f"({self.identity.subtype}); plug the first one in again, or start a new gateway",
                    ExitCode.WRONG_ROBOT,
                )
            model = self.model or self._find_model(identity)
        except GatewayError as error:
            self._events.append(RobotRejected(error))
            self._diagnosis.note_rejected(str(error))
            self._connector.rest(now)
            self._outbox.put("close", CLOSE)
            return
        if self._plausibility is None:
            self.identity, self.model = identity, model
            self._codec = SipCodec(model)
            self._plausibility = Plausibility(model)
            self._limit_speeds()
        self._plausibility.begin_link()
        self._is_open = True
        self._sip_at = now
        self._events.append(HandshakeCompleted(identity, model, self.baud))
        self._outbox.put("open", encode_command(Command.OPEN))
        for name, frame in acceleration_frames(self._settings.limits):
            self._outbox.put(name, frame)
        self._motion.begin_link(now)
        for element in self._elements.values():
            element.begin_link(model, now)
        if self._connector.hangs_up_on_close or identity.name in SIMULATOR_NAMES:
            self._meet_simulator(now)

    def _meet_simulator(self, now: float) -> None:
        for element in self._elements.values():
            element.meet_simulator(now)

    def _read(self, payload: bytes, now: float) -> None:
        """Take a packet of an open robot."""
        assert self.model is not None  # set before the robot is opened
        try:
            packet = decode_packet(payload, self.model, self._codec)
        except DecodeError:
            self.damaged["content"] += 1
            return
        match packet:
            case StandardSip():
                self._take_sip(packet, now)
            case Configuration():
                self.configuration = packet
                self._limit_speeds()
                self._events.append(packet)
                for element in self._elements.values():
                    element.configure(packet, now)
                if packet.serial == SIMULATOR_SERIAL:
                    self._meet_simulator(now)
        for taker in self._takers.get(type(packet), ()):
            taker.take(packet, now)

    def _take_sip(self, sip: StandardSip, now: float) -> None:
        assert self.model is not None
        assert self._plausibility is not None  # both set before the robot is opened
        verdict = self._plausibility.judge(sip, now)
        if verdict.doubt is not None:
            self.implausible[verdict.doubt] += 1
            return
        if not verdict.continues:
            self.odometry.forget_counters()
        self._sip_at = now
        turned = self.lookup(Gyro).take_turn()
        believes_gyro = self._settings.use_gyro and not is_at_rest(sip)  # at rest its noise would accumulate
        self.odometry.update(sip, self.model, turned if believes_gyro else None)
        odometry = self.odometry
        is_first, self.is_connected = not self.is_connected, True
        self._diagnosis.end()
        self._events.append(
            SipReceived(sip, odometry.pose, odometry.covariance, odometry.linear, odometry.angular, is_first)
        )
        self._motion.take(sip, now)
        self._rate_raiser.see()
        if is_first:
            self._rate_raiser.begin(now)
        for element in self._elements.values():
            element.see(sip, now)

    def _travel_time(self, way: float, speed: float, acceleration: str, deceleration: str) -> float:
        if self.model is None:
            return 0.0  # the command is refused: there is no robot yet
        known = self.accelerations or known_accelerations(self._settings.limits, self.model, None)
        return travel_time(way, speed, known[acceleration], known[deceleration])

    def _limit_speeds(self) -> None:
        """Set the lowest limits of model, robot and user; zero in a CONFIGpac means that it has none."""
        assert self.model is not None
        reported = self.configuration or Configuration()
        limits = self._settings.limits
        linear = self.model.max_velocity, reported.velocity_max, reported.velocity_top, limits.linear_m_s
        angular = self.model.max_rotation, reported.rotation_max, reported.rotation_top, limits.angular_rad_s
        least = min(limit for limit in linear if limit), min(limit for limit in angular if limit)
        self._motion.limit_speeds(*least, speed_frames(limits, *least))

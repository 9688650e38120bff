"""Receives velocities, commands and lease requests for one robot.

Handlers run on threads of the bus and reach the driver through a `Commander`. All of them run under its lock, except
the halt of elements on cables of their own, which follows the robot's own STOP. Stop and e-stop are handled on the
thread that receives them, so that they wait for no other query. Of velocities only the latest counts.
"""

from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Any, Protocol, TypeVar

from bus import Bus, KeyNotValid, MessageError, Refused, Sample, Subscription, keys
from bus.heartbeat import LONGEST_PERIOD, SILENCE, heartbeat_key
from bus.keys import Topic
from bus.messages import NS_PER_S, Twist, decode, stamp_ns
from bus.validation import sentence
from gateway.bindings import Binding, MotionBindings
from gateway.commands import BASE, DETACH, HEARTBEAT, TOKEN, Arguments, CommandRow, check_arguments
from gateway.driver import Driver
from gateway.elements.adapter import BusAdapter, RobotContext
from gateway.errors import CommandRefused, LineBlocked
from gateway.events import MotionEnd
from gateway.lease import DEFAULT_SECONDS, ROBOT, Leases
from gateway.motion import CMD_VEL_SILENCE

T = TypeVar("T")

NOTICE_SHOWN = 2.0
"""Seconds for which a refused command, or the loss of a commander, counts among the faults."""
VELOCITY_PERIOD = 0.005
"""Least seconds between two velocities that are looked at; the robot takes no more than one in its cycle."""
CLOCK_TOLERANCE = 0.2
"""Seconds by which the sender's clock may be ahead of this machine's."""
HALT_ANYWAY = 4.0
"""Seconds after its command in which an element is halted whether or not it reports a motion: servos that have just
been switched on take up to 3.5 s to begin."""
DETACHED = "this motion is detached: it does not stop when its commander dies or freezes"

STOPPING = (keys.STOP, keys.ESTOP)
"""Commands that stop the elements on cables of their own as well."""
LEASE_ARGUMENTS: dict[str, tuple[dict[str, type], dict[str, type]]] = {
    "take": ({"holder": str}, {"priority": int, "seconds": float, "element": str}),
    "renew": ({TOKEN: str}, {"seconds": float}),
    "release": ({TOKEN: str}, {}),
}
"""What each lease operation takes, and may take."""

Handler = Callable[[dict[str, Any], float], dict[str, Any]]
"""Returns the reply to a query, from its arguments and the steady time, s; called under the robot's lock."""


class Commander(Protocol):
    """Gives threads of the bus access to the driver."""

    def command(self, call: Callable[[Driver, float], T]) -> T:
        """Call a function with the driver and the steady time under the robot's lock, and write the bytes due.

        Raises:
            LineBlocked: The robot's line hangs; the function was not called.
        """

    def post(self, call: Callable[[Driver, float], object]) -> None:
        """Call a function likewise without waiting, as soon as the line does not hang; it must not raise."""


class CommandServer(Subscription):
    """One robot's subscribers and queryables.

    refused: commands not obeyed, counted by the key's suffix. lease_has_changed: since someone last set it to false.
    bindings: of motions to the heartbeats of their commanders.
    """

    def __init__(
        self,
        robot: RobotContext,
        bus: Bus,
        commander: Commander,
        new_token: Callable[[], str],
        wall_clock: Callable[[], int],
        adapters: Sequence[BusAdapter[Any]],
    ) -> None:
        self._driver = robot.driver
        self._adapters = adapters
        self._commander = commander
        self._wall_clock = wall_clock
        self._last_notice: tuple[float, str] | None = None
        self.lease_has_changed = True
        self.refused: Counter[str] = Counter()
        # An element on a cable of its own comes later, and obeys in place of one of its kind on the robot's line.
        rows = {row.topic: (adapter, row) for adapter in adapters for row in adapter.commands}
        self.leases = Leases(new_token, {row.moves for _, row in rows.values() if row.moves})
        self.bindings = MotionBindings(bus, self._on_beat)
        self._declared = [
            self.bindings,
            bus.subscribe_latest(keys.CMD_VEL.key(robot.name), self._on_cmd_vel, VELOCITY_PERIOD),
            bus.subscribe_latest(keys.CMD_VEL_STAMPED.key(robot.name), self._on_cmd_vel_stamped, VELOCITY_PERIOD),
            bus.serve(keys.LEASE.key(robot.name), self._answerer(keys.LEASE, self._lease)),
            bus.serve(keys.LEASE_STATE.key(robot.name), self._answerer(keys.LEASE_STATE, self._show_leases)),
            *(
                bus.serve(
                    topic.key(robot.name),
                    self._answerer(topic, self._handler(adapter, row)),
                    urgent=topic in STOPPING,
                )
                for topic, (adapter, row) in rows.items()
            ),
        ]

    @property
    def deadline(self) -> float:
        """When `settle` is due, s."""
        return min(self.leases.deadline, self.bindings.deadline)

    def recent_notice(self, now: float) -> str | None:
        """Return the latest refusal or lost commander while it is recent."""
        at, what = self._last_notice or (now - NOTICE_SHOWN, "")
        return what if now - at < NOTICE_SHOWN else None

    def settle(self) -> None:
        """End the leases whose time is over, and the motions whose commander is silent."""
        with suppress(LineBlocked):  # it is still due at the next call
            self._commander.command(lambda driver, now: self._settle(now))

    def close(self) -> None:
        """Withdraw the subscribers and queryables."""
        for declared in self._declared:
            declared.close()

    def _on_cmd_vel(self, sample: Sample) -> None:
        self._drive(keys.CMD_VEL, sample, lambda: decode(keys.CMD_VEL.type_name, sample.payload))

    def _on_cmd_vel_stamped(self, sample: Sample) -> None:
        self._drive(keys.CMD_VEL_STAMPED, sample, lambda: self._fresh(sample.payload))

    def _fresh(self, payload: bytes) -> Twist:
        """Return the twist of a stamped command; refuse an old one. A stamp of zero is not checked."""
        message = decode(keys.CMD_VEL_STAMPED.type_name, payload)
        stamp = stamp_ns(message.header)
        age = (self._wall_clock() - stamp) / NS_PER_S if stamp else 0.0
        if age > CMD_VEL_SILENCE:
            raise CommandRefused(f"the command is {age:.3g} s old by its stamp; at most {CMD_VEL_SILENCE} s are obeyed")
        if age < -CLOCK_TOLERANCE:
            raise CommandRefused(
                f"the command is stamped {-age:.3g} s in the future; at most {CLOCK_TOLERANCE} s are obeyed, "
                "so synchronise the clocks"
            )
        twist: Twist = message.twist
        return twist

    def _drive(self, topic: Topic, sample: Sample, read: Callable[[], Twist]) -> None:
        """Obey a velocity from a stream; a stream has no reply, so errors are counted and published."""

        def drive(driver: Driver, now: float) -> None:
            try:
                twist = read()
                self._check_lease(BASE, sample.attachment.decode("utf-8", "replace"), now)
                driver.set_velocity(twist.linear.x, twist.angular.z, now)
            except (MessageError, CommandRefused) as refusal:
                self._count(topic, refusal, now)

        try:
            self._commander.command(drive)
        except LineBlocked:
            self.refused[topic.suffix] += 1

    def _answerer(self, topic: Topic, handle: Handler) -> Callable[[dict[str, Any]], dict[str, Any]]:
        """Wrap a handler for the bus: it runs under the lock, and refusals are counted and replied."""

        def answer(given: dict[str, Any]) -> dict[str, Any]:
            def call(driver: Driver, now: float) -> dict[str, Any]:
                try:
                    return handle(given, now)
                except CommandRefused as refusal:
                    self._count(topic, refusal, now)
                    raise Refused(str(refusal)) from refusal

            try:
                reply = self._commander.command(call)
            except LineBlocked as blocked:
                self.refused[topic.suffix] += 1
                if topic in STOPPING:
                    self._commander.post(lambda driver, now: self._obey_late(handle, given, now))
                raise Refused(str(blocked)) from blocked
            finally:
                if topic in STOPPING:  # also where the robot's own line hangs
                    self._halt_cables()
            if HEARTBEAT in given:
                self.bindings.follow()
            return reply

        return answer

    def _obey_late(self, handle: Handler, given: dict[str, Any], now: float) -> None:
        """Stop a robot whose line has hung, and latch an e-stop: who asked for it was told only that the line hangs."""
        with suppress(CommandRefused):  # it would have been refused at once
            handle(given, now)

    def _count(self, topic: Topic, refusal: Exception, now: float) -> None:
        self.refused[topic.suffix] += 1
        self._last_notice = now, sentence(f"{topic.suffix} was refused: {refusal}")

    def _check_lease(self, element: str, token: str, now: float) -> None:
        """Refuse a command on an element while another client holds the lease on it or on the robot.

        Raises:
            CommandRefused: Another client does, or the token has expired.
        """
        self._settle(now)
        self.leases.check(element, token)

    def _settle(self, now: float) -> None:
        self._change_holders(self.leases.expire(now), now)
        for binding in self.bindings.expire(now):
            self._abandon(binding, now)

    def _change_holders(self, of: Sequence[str], now: float) -> None:
        """Stop what the former holder has set in motion, and nothing else."""
        for what in of:
            self.lease_has_changed = True
            self._halt(what, now)

    def _halt(self, what: str, now: float, end: MotionEnd = MotionEnd.STOPPED) -> None:
        """Stop one element, or all of them if it is the robot."""
        for adapter in self._adapters:
            if what in (ROBOT, adapter.name):
                adapter.halt(now, end)

    def _halt_cables(self) -> None:
        """Stop the elements on cables of their own, once the robot's own STOP is written: these cables may be slow."""
        for adapter in self._adapters:
            if adapter.cable is not None:
                adapter.cable.halt()

    def _on_beat(self, key: str) -> None:
        with suppress(LineBlocked):  # its motion ends like that of a commander that was silent
            self._commander.command(lambda driver, now: self.bindings.beat(key, now))

    def _abandon(self, binding: Binding, now: float) -> None:
        """Stop a motion whose commander is silent, if it still goes on."""
        if not self._goes_on(binding, now):
            return
        self._last_notice = (
            now,
            (f"the {binding.element} was stopped: its commander, heartbeat {binding.key}, was silent for {SILENCE} s"),
        )
        self._halt(binding.element, now, MotionEnd.COMMANDER_LOST)

    def _goes_on(self, binding: Binding, now: float) -> bool:
        if binding.motion_id is not None:
            return self._driver.motion_id == binding.motion_id
        return now - binding.began_at < HALT_ANYWAY or any(
            adapter.is_moving(now) for adapter in self._adapters if adapter.name == binding.element
        )

    def _show_leases(self, given: dict[str, Any], now: float) -> dict[str, Any]:
        """Return what is published, for clients that come later or may only read."""
        return self._lease({}, now)

    def _lease(self, given: dict[str, Any], now: float) -> dict[str, Any]:
        """Answer `{"do": "take" | "renew" | "release" | "show", ...}`; an empty object shows."""
        self._settle(now)
        what = given.get("do", "show")
        takes, optional = LEASE_ARGUMENTS.get(what, ({}, {})) if isinstance(what, str) else ({}, {})
        arguments = check_arguments(f"lease {what}", {k: v for k, v in given.items() if k != "do"}, takes, optional)
        match what:
            case "take":
                return self._take(arguments, now)
            case "renew":
                lease = self.leases.renew(arguments[TOKEN], arguments.get("seconds"), now)
                return lease.told(now)
            case "release":
                lease = self.leases.release(arguments[TOKEN])
                self._change_holders([lease.what], now)
                return lease.told(now)
            case "show":
                return self.leases.state(now)
        raise CommandRefused(f"a lease cannot {what!r}; use take, renew, release or show")

    def _take(self, arguments: Arguments, now: float) -> dict[str, Any]:
        seconds, priority = arguments.get("seconds", DEFAULT_SECONDS), arguments.get("priority", 0)
        what = arguments.get("element", ROBOT)
        lease, token, standing = self.leases.take(what, arguments["holder"], priority, seconds, now)
        self._change_holders(standing, now)
        return {"token": token, **lease.told(now)}

    def _handler(self, adapter: BusAdapter[Any], row: CommandRow) -> Handler:
        name = row.topic.suffix.rpartition("/")[2]

        def handle(given: dict[str, Any], now: float) -> dict[str, Any]:
            arguments = check_arguments(name, given, row.takes, row.optional)
            if row.moves:
                self._check_lease(row.moves, arguments.get(TOKEN, ""), now)
            if row.duration is None:
                return {"accepted": True, **(row.perform(adapter, arguments, now) or {})}
            duration = row.duration(adapter, arguments, now)
            return {"accepted": True, **self._begin(name, adapter, row, duration, arguments, now)}

        return handle

    def _begin(
        self, name: str, adapter: BusAdapter[Any], row: CommandRow, duration: float, arguments: Arguments, now: float
    ) -> dict[str, Any]:
        """Begin a motion, bound to its commander's heartbeat if the command names one; return the reply's contents.

        Raises:
            CommandRefused: A motion of this duration needs a heartbeat; or the driver refuses it.
        """
        key, is_detached = arguments.get(HEARTBEAT), arguments.get(DETACH, False)
        if key is not None:
            try:
                heartbeat_key(key)
            except KeyNotValid as error:
                raise CommandRefused(str(error)) from error
        elif duration > self._driver.unbound_motion and not is_detached:
            raise CommandRefused(
                f"this {name} takes about {duration:.1f} s; without a heartbeat, at most "
                f"{self._driver.unbound_motion:g} s are allowed, since it would not stop when its commander dies. Name "
                f"a heartbeat that you publish at least every {LONGEST_PERIOD} s "
                '("heartbeat": "NAME/heartbeat"), or send "detach": true'
            )
        rest = {name: value for name, value in arguments.items() if name not in (HEARTBEAT, DETACH)}
        reply = row.perform(adapter, rest, now) or {}
        self.bindings.release(row.moves)
        if key is not None and duration > 0.0:
            self.bindings.bind(Binding(row.moves, key, reply.get("id"), now))
        return {**reply, "warning": DETACHED} if is_detached and key is None else reply

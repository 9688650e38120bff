"""What a robot is told over the bus: velocities, commands, and who holds its leases.

Handlers run on threads of the bus and reach the driver through a `Commander`; everything here happens under its lock,
but for halting what hangs on cables of its own once the robot has been told to stop. Stop and e-stop are handled on
the thread that receives, so that they wait for no other query; of velocities only the latest is looked at.
"""

from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any, Protocol, TypeVar

from bus import Bus, KeyNotValid, MessageError, Refused, Sample, Subscription, keys
from bus.heartbeat import LONGEST_PERIOD, SILENCE, heartbeat_key
from bus.keys import Topic
from bus.messages import NS_PER_S, Twist, decode, stamp_ns
from bus.validation import sentence
from gateway.bindings import Binding, MotionBindings
from gateway.commands import BASE, COMMANDS, DETACH, HEARTBEAT, TOKEN, Arguments, CommandRow, check_arguments
from gateway.driver import Driver
from gateway.elements.all_adapters import ADAPTERS
from gateway.elements.cable_adapter import CableAdapter
from gateway.errors import CommandRefused
from gateway.events import MotionEnd
from gateway.lease import DEFAULT_SECONDS, ROBOT, Lease, Leases
from gateway.motion import CMD_VEL_SILENCE

T = TypeVar("T")

NOTICE_SHOWN = 2.0
"""Seconds for which a refused command, or the loss of a commander, counts among the faults."""
VELOCITY_PERIOD = 0.005
"""Least seconds between two velocities that are looked at; the robot takes no more than one in its cycle."""
CLOCK_TOLERANCE = 0.2
"""Seconds by which the sender's clock may be ahead of this machine's."""
HALT_ANYWAY = 4.0
"""Seconds after its command in which an element is halted whether or not it says that it moves: servos that have just
been switched on take up to 3.5 s to begin."""
DETACHED = "this motion is detached: nobody stops it when its commander dies or freezes"

_ROWS = (*COMMANDS, *(row for adapter in ADAPTERS for row in adapter.commands))
STOPPING = (keys.STOP, keys.ESTOP)
"""What stops the elements on cables of their own as well."""
LEASE_ARGUMENTS: dict[str, tuple[dict[str, type], dict[str, type]]] = {
    "take": ({"holder": str}, {"priority": int, "seconds": float, "element": str}),
    "renew": ({TOKEN: str}, {"seconds": float}),
    "release": ({TOKEN: str}, {}),
}
"""What each lease operation takes, and may take."""

Handler = Callable[[dict[str, Any], Driver, float], dict[str, Any]]


class Commander(Protocol):
    """The way to the driver from a thread of the bus."""

    def command(self, give: Callable[[Driver, float], T]) -> T:
        """Call `give` with the driver and the steady time, nobody else meanwhile, and write what follows."""
        ...


class CommandServer(Subscription):
    """One robot's subscribers and queryables.

    refused: commands not obeyed, counted by the key's suffix. lease_has_changed: since someone last set it to false.
    bindings: of motions to the heartbeats of their commanders.
    """

    def __init__(
        self,
        name: str,
        bus: Bus,
        commander: Commander,
        new_token: Callable[[], str],
        wall_clock: Callable[[], int],
        cable_adapters: Sequence[CableAdapter[Any]] = (),
    ) -> None:
        self._cable_adapters = cable_adapters
        self._commander = commander
        self._wall_clock = wall_clock
        self._last_notice: tuple[float, str] | None = None
        self.lease_has_changed = True
        self.refused: Counter[str] = Counter()
        # An element on a cable of its own obeys the key that one of its kind on the robot's cable would.
        rows = {row.topic: row for row in (*_ROWS, *(row for adapter in cable_adapters for row in adapter.commands))}
        self.leases = Leases(new_token, {row.moves for row in rows.values() if row.moves})
        self.bindings = MotionBindings(bus, self._on_beat)
        self._declared = [
            self.bindings,
            bus.subscribe_latest(keys.CMD_VEL.key(name), self._on_cmd_vel, VELOCITY_PERIOD),
            bus.subscribe_latest(keys.CMD_VEL_STAMPED.key(name), self._on_cmd_vel_stamped, VELOCITY_PERIOD),
            bus.serve(keys.LEASE.key(name), self._answerer(keys.LEASE, self._lease)),
            bus.serve(keys.LEASE_STATE.key(name), self._answerer(keys.LEASE_STATE, self._show_leases)),
            *(
                bus.serve(
                    row.topic.key(name),
                    self._answerer(row.topic, self._handler(row)),
                    urgent=row.topic in STOPPING,
                )
                for row in rows.values()
            ),
        ]

    @property
    def deadline(self) -> float:
        """When `settle` is due, s."""
        return min(self.leases.deadline, self.bindings.deadline)

    def recent_notice(self, now: float) -> str | None:
        """The latest refusal or lost commander, while it is news."""
        at, what = self._last_notice or (now - NOTICE_SHOWN, "")
        return what if now - at < NOTICE_SHOWN else None

    def settle(self) -> None:
        """End the leases whose time is over, and the motions whose commander is silent."""
        self._commander.command(self._settle)

    def close(self) -> None:
        """Listen no more."""
        for declared in self._declared:
            declared.close()

    def _on_cmd_vel(self, sample: Sample) -> None:
        self._drive(keys.CMD_VEL, sample, lambda: decode(keys.CMD_VEL.type_name, sample.payload))

    def _on_cmd_vel_stamped(self, sample: Sample) -> None:
        self._drive(keys.CMD_VEL_STAMPED, sample, lambda: self._fresh(sample.payload))

    def _fresh(self, payload: bytes) -> Twist:
        """The twist of a stamped command, unless its stamp says that it is old; a stamp of zero says nothing."""
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
        """Take a velocity from a stream; a stream has nobody to answer, so what is wrong is counted and shown."""

        def give(driver: Driver, now: float) -> None:
            try:
                twist = read()
                self._pass(BASE, sample.attachment.decode("utf-8", "replace"), driver, now)
                driver.set_velocity(twist.linear.x, twist.angular.z, now)
            except (MessageError, CommandRefused) as refusal:
                self._count(topic, refusal, now)

        self._commander.command(give)

    def _answerer(self, topic: Topic, handle: Handler) -> Callable[[dict[str, Any]], dict[str, Any]]:
        """Turn a handler into what the bus serves: under the lock, refusals counted and answered."""

        def answer(given: dict[str, Any]) -> dict[str, Any]:
            def give(driver: Driver, now: float) -> dict[str, Any]:
                try:
                    return handle(given, driver, now)
                except CommandRefused as refusal:
                    self._count(topic, refusal, now)
                    raise Refused(str(refusal)) from refusal

            given_answer = self._commander.command(give)
            if topic in STOPPING:
                self._halt_elements()  # now that the robot's own STOP is on its way: their cables may be slow
            elif HEARTBEAT in given:
                self.bindings.follow()
            return given_answer

        return answer

    def _count(self, topic: Topic, refusal: Exception, now: float) -> None:
        self.refused[topic.suffix] += 1
        self._last_notice = now, sentence(f"{topic.suffix} was refused: {refusal}")

    def _pass(self, element: str, token: str, driver: Driver, now: float) -> None:
        """Let the holder of the lease on the element or on the robot pass, and everyone while nobody holds either."""
        self._settle(driver, now)
        self.leases.check(element, token)

    def _settle(self, driver: Driver, now: float) -> None:
        self._change_holders(self.leases.expire(now), driver, now)
        for binding in self.bindings.expire(now):
            self._abandon(binding, driver, now)

    def _change_holders(self, of: Sequence[str], driver: Driver, now: float) -> None:
        """What the holder before has set going ends here; nothing else does."""
        for what in of:
            self.lease_has_changed = True
            if what == ROBOT:
                driver.halt(now)
            self._halt(what, driver, now)

    def _halt(self, what: str, driver: Driver, now: float, end: MotionEnd = MotionEnd.STOPPED) -> None:
        """Stop one element, whichever cable it hangs on; what hangs on others if it is the robot."""
        if what == BASE:
            driver.halt_base(now, end)
        for adapter in ADAPTERS:
            if adapter.name == what:
                adapter.halt(driver, now)
        for cable_adapter in self._cable_adapters:
            if what in (ROBOT, cable_adapter.name):
                cable_adapter.halt()

    def _on_beat(self, key: str) -> None:
        self._commander.command(lambda driver, now: self.bindings.beat(key, now))

    def _abandon(self, binding: Binding, driver: Driver, now: float) -> None:
        """The commander of a motion is silent: stop what it has set going, if it still goes on."""
        if not self._goes_on(binding, driver, now):
            return
        self._last_notice = (
            now,
            (f"the {binding.element} was stopped: its commander, heartbeat {binding.key}, was silent for {SILENCE} s"),
        )
        self._halt(binding.element, driver, now, MotionEnd.COMMANDER_LOST)

    def _goes_on(self, binding: Binding, driver: Driver, now: float) -> bool:
        if binding.motion_id is not None:
            return driver.motion_id == binding.motion_id
        return (
            now - binding.began_at < HALT_ANYWAY
            or any(adapter.is_moving(driver, now) for adapter in ADAPTERS if adapter.name == binding.element)
            or any(adapter.driver.is_moving for adapter in self._cable_adapters if adapter.name == binding.element)
        )

    def _show_leases(self, given: dict[str, Any], driver: Driver, now: float) -> dict[str, Any]:
        """What is published, for those who come later or may only look."""
        return self._lease({}, driver, now)

    def _lease(self, given: dict[str, Any], driver: Driver, now: float) -> dict[str, Any]:
        """Answer `{"do": "take" | "renew" | "release" | "show", ...}`; an empty object shows."""
        self._settle(driver, now)
        what = given.get("do", "show")
        takes, optional = LEASE_ARGUMENTS.get(what, ({}, {})) if isinstance(what, str) else ({}, {})
        arguments = check_arguments(f"lease {what}", {k: v for k, v in given.items() if k != "do"}, takes, optional)
        match what:
            case "take":
                return self._take(arguments, driver, now)
            case "renew":
                lease = self.leases.renew(arguments[TOKEN], arguments.get("seconds"), now)
                return _told(lease, now)
            case "release":
                lease = self.leases.release(arguments[TOKEN])
                self._change_holders([lease.what], driver, now)
                return _told(lease, now)
            case "show":
                return self.leases.state(now)
        raise CommandRefused(f"a lease cannot {what!r}; say take, renew, release or show")

    def _take(self, arguments: Arguments, driver: Driver, now: float) -> dict[str, Any]:
        seconds, priority = arguments.get("seconds", DEFAULT_SECONDS), arguments.get("priority", 0)
        what = arguments.get("element", ROBOT)
        lease, token, standing = self.leases.take(what, arguments["holder"], priority, seconds, now)
        self._change_holders(standing, driver, now)
        return {"token": token, **_told(lease, now)}

    def _handler(self, row: CommandRow) -> Handler:
        name = row.topic.suffix.rpartition("/")[2]

        def handle(given: dict[str, Any], driver: Driver, now: float) -> dict[str, Any]:
            arguments = check_arguments(name, given, row.takes, row.optional)
            if row.moves:
                self._pass(row.moves, arguments.get(TOKEN, ""), driver, now)
            if row.duration is None:
                return {"accepted": True, **(row.give(driver, arguments, now) or {})}
            return {
                "accepted": True,
                **self._begin(name, row, row.duration(driver, arguments, now), arguments, driver, now),
            }

        return handle

    def _begin(
        self, name: str, row: CommandRow, duration: float, arguments: Arguments, driver: Driver, now: float
    ) -> dict[str, Any]:
        """Begin a motion, bound to its commander's heartbeat if the command names one; return the answer's contents.

        Raises:
            CommandRefused: It would go on for long without anyone to stop it; or the driver refuses it.
        """
        key, is_detached = arguments.get(HEARTBEAT), arguments.get(DETACH, False)
        if key is not None:
            try:
                heartbeat_key(key)
            except KeyNotValid as error:
                raise CommandRefused(str(error)) from error
        elif duration > driver.unbound_motion and not is_detached:
            raise CommandRefused(
                f"this {name} takes about {duration:.1f} s, and nobody would stop it if its commander died: without a "
                f"heartbeat at most {driver.unbound_motion:g} s are allowed; name one that you publish at least every "
                f'{LONGEST_PERIOD} s ("heartbeat": "NAME/heartbeat"), or send "detach": true'
            )
        rest = {name: value for name, value in arguments.items() if name not in (HEARTBEAT, DETACH)}
        answer = row.give(driver, rest, now) or {}
        self.bindings.release(row.moves)
        if key is not None and duration > 0.0:
            self.bindings.bind(Binding(row.moves, key, answer.get("id"), now))
        return {**answer, "warning": DETACHED} if is_detached and key is None else answer

    def _halt_elements(self) -> None:
        for adapter in self._cable_adapters:
            adapter.halt()


def _told(lease: Lease, now: float) -> dict[str, Any]:
    """What its holder is answered."""
    return {"element": lease.what, **lease.state(now)}

"""The gripper on the microcontroller: two paddles on a lift.

Source: gripper manual (commands, state byte, digital inputs), and the client libraries for which byte of the SIP means
what: the state byte follows the sonar readings, and again in the byte after it; on the PeopleBot that second byte is
laid out as the digital inputs are.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import inf
from typing import Any

import configs
from gateway.elements.asked import AskedElement
from gateway.errors import CommandRefused
from gateway.events import GripperJoints, GripperSeen
from p2os import Command, Configuration, GripperReport, StandardSip, encode_command
from p2os.accessories.gripper import GripperFlags, GripperInput, GripperKind, GripperOrder
from p2os.arguments import PacketRequest

ORDERS = {
    "open": (GripperOrder.OPEN,),
    "close": (GripperOrder.CLOSE,),
    "stop": (GripperOrder.STOP, GripperOrder.LIFT_STOP),
    "up": (GripperOrder.UP,),
    "down": (GripperOrder.DOWN,),
    "store": (GripperOrder.STORE,),
    "deploy": (GripperOrder.DEPLOY,),
    "halt": (GripperOrder.HALT,),
}
"""Orders and their arguments of GRIPPER; to stop, paddles and lift get one each."""
STOPPING = ("stop", "halt")


@dataclass(frozen=True, slots=True)
class _GripperTravel:
    """Travel, m, and speeds, m/s: opening between the open paddles, lift, and the speed of each."""

    opening: float
    lift: float
    paddle_speed: float
    lift_speed: float

    @classmethod
    def from_table(cls, table: Mapping[str, Any]) -> "_GripperTravel":
        """Read what is needed of a gripper's file in `configs/accessories`."""
        return cls(table["opening_m"], table["lift_travel_m"], table["paddle_speed_m_s"], table["lift_speed_m_s"])


TRAVELS = {GripperKind.PIONEER: "gripper-pioneer", GripperKind.PEOPLEBOT: "gripper-peoplebot"}
"""Files of `configs/accessories`."""


class GripperElement(AskedElement[GripperReport]):
    """Asks once whether there is one; SIPs bring its state."""

    takes = (GripperReport,)
    question = Command.GRIPREQUEST, PacketRequest.ONE
    _kind = GripperKind.NONE
    _has_failed = False
    _moves = False

    @property
    def faults(self) -> Sequence[str]:
        """The errors that the firmware reports."""
        return ("the gripper reports an error of its paddles or its lift",) if self._has_failed else ()

    def configure(self, configuration: Configuration, now: float) -> None:
        """Take the gripper of an older firmware, which has no GRIPPERpac."""
        if configuration.gripper and not self.is_present:
            self._meet(configuration.gripper)

    def meet_simulator(self, now: float) -> None:
        """Do not ask: to simulators GRIPREQUEST is an old number that sets the last bearing of their laser."""
        self._outbox.drop(Command.GRIPREQUEST)
        self._asks_left = 0
        self.deadline = inf

    def take(self, packet: GripperReport, now: float) -> None:
        """Take the robot's gripper."""
        super().take(packet, now)
        self._meet(packet.kind)

    def see(self, sip: StandardSip, now: float) -> None:
        """Take the gripper's state."""
        if not self.is_present:
            return
        state = GripperFlags(sip.gripper_state or sip.analog_port)
        inputs = GripperInput(sip.digital_in)
        moving = bool(state & GripperFlags.PADDLES_MOVING), bool(state & GripperFlags.LIFT_MOVING)
        if self._kind is GripperKind.PEOPLEBOT and sip.analog_port != sip.gripper_state:
            inputs = GripperInput(sip.analog_port)
            moving = bool(inputs & GripperInput.PADDLES_MOVING), bool(inputs & GripperInput.LIFT_MOVING)
        self._moves = any(moving)
        if self._stop.is_due(self._moves, now):
            self._put_halt()
        self._has_failed = bool(state & (GripperFlags.PADDLES_ERROR | GripperFlags.LIFT_ERROR))
        seen = GripperSeen(
            paddles_open=_only(state, GripperFlags.PADDLES_OPEN, GripperFlags.PADDLES_CLOSED),
            paddles_closed=_only(state, GripperFlags.PADDLES_CLOSED, GripperFlags.PADDLES_OPEN),
            paddles_moving=moving[0],
            lift_up=_only(state, GripperFlags.LIFT_UP, GripperFlags.LIFT_DOWN),
            lift_down=_only(state, GripperFlags.LIFT_DOWN, GripperFlags.LIFT_UP),
            lift_moving=moving[1],
            outer_beam=bool(inputs & GripperInput.OUTER_BEAM),
            inner_beam=bool(inputs & GripperInput.INNER_BEAM),
            left_contact=not inputs & GripperInput.LEFT_CONTACT,
            right_contact=not inputs & GripperInput.RIGHT_CONTACT,
        )
        self._announce(seen)
        self._announce(self._joints(seen))

    def order(self, what: str) -> None:
        """Move it.

        Raises:
            CommandRefused: There is no such order.
        """
        if what not in ORDERS:
            raise CommandRefused(f"a gripper cannot {what!r}; use {', '.join(ORDERS)}")
        if what in STOPPING:
            self._drop()
            self._stop.begin()
        else:
            self._stop.end()
        for argument in ORDERS[what]:
            kind = Command.GRIPPER, argument
            self._outbox.drop(kind)  # the latest order comes last
            self._ask(Command.GRIPPER, argument, kind)

    def duration(self, what: str) -> float:
        """Return the expected duration of an order, s; 0 for one that moves nothing."""
        if not self.is_present or what in STOPPING:
            return 0.0
        paddles = self._travel.opening / 2.0 / self._travel.paddle_speed
        lift = self._travel.lift / self._travel.lift_speed
        return {"open": paddles, "close": paddles}.get(what, max(paddles, lift))

    def is_moving(self, now: float) -> bool:
        """Return whether paddles or lift move, by the last SIP."""
        return self._moves

    def halt(self, now: float) -> None:
        """Stop paddles and lift where they are; what stops goes first."""
        if self.is_present:
            self._drop()
            self._put_halt()
            self._stop.begin()

    def _put_halt(self) -> None:
        self._outbox.put((Command.GRIPPER, GripperOrder.HALT), encode_command(Command.GRIPPER, GripperOrder.HALT))

    def _drop(self) -> None:
        """Take back the orders that still wait."""
        self._outbox.drop(*((Command.GRIPPER, argument) for arguments in ORDERS.values() for argument in arguments))

    def _meet(self, kind: int) -> None:
        self._kind = GripperKind.PEOPLEBOT if kind == GripperKind.PEOPLEBOT else GripperKind.PIONEER
        self._travel = configs.load(_GripperTravel, "accessories", TRAVELS[self._kind])
        self.is_present = kind != GripperKind.NONE

    def _joints(self, seen: GripperSeen) -> GripperJoints:
        """Return the positions of the joints as far as switches show them; unknown for paddles that hold something."""
        holds = seen.left_contact or seen.right_contact or seen.outer_beam or seen.inner_beam
        opening = self._travel.opening if seen.paddles_open else None
        if seen.paddles_closed and not holds:
            opening = 0.0
        lift = self._travel.lift if seen.lift_up else 0.0 if seen.lift_down else None
        return GripperJoints(opening, lift)


def _only(state: GripperFlags, this: GripperFlags, other: GripperFlags) -> bool:
    return bool(state & this) and not state & other

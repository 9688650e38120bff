"""The gripper server: paddles and lift behind GRIPPER, GRIPPERVAL and GRIPREQUEST.

Source: fact sheet, accessories, section 2. After power-on neither motor's place is known, though limit switches tell
that it is at one of its ends: the first motion that reaches an end tells which.
"""

from collections.abc import Callable, Mapping

from p2os.accessories.gripper import (
    INTERVAL,
    LONGEST_CARRY,
    LONGEST_PRESS,
    GripperFlags,
    GripperInput,
    GripperKind,
    GripperOrder,
)
from p2os.accessory_packets import GripperReport
from p2os_emu.body import GripperMechanism, GripperMechanismState
from p2os_emu.gripper_model import GripperModel

GRASP_TIME = 10 * INTERVAL
"""s that paddles go on closing after both contacts have triggered, unless PRESS says otherwise."""
AT_END = 0.01
"""Of the whole way, within which a limit switch is pressed."""

# A motor's half of the state byte: the paddles' is the lower one, and the lift's is like it.
_FAR, _NEAR = int(GripperFlags.PADDLES_OPEN), int(GripperFlags.PADDLES_CLOSED)
_MOVING, _FAILED = int(GripperFlags.PADDLES_MOVING), int(GripperFlags.PADDLES_ERROR)
_UNKNOWN = _FAR | _NEAR


class _Motor:
    """One motor between two ends, far (open, up) and near (closed, down).

    direction: 1 towards the far end, -1 towards the near one, 0 at rest. timeout: s that a whole way may
    take. nibble: its half of the state byte.
    """

    __slots__ = ("_at", "_failed", "_is_timed", "_left", "direction", "timeout")

    def __init__(self) -> None:
        self.timeout = 0.0
        self.power_on()

    @property
    def nibble(self) -> int:
        return _MOVING | self._failed if self.direction else self._at | self._failed

    def power_on(self) -> None:
        self.direction = 0
        self._at = _UNKNOWN
        self._failed = 0

    def start(self, direction: int, seconds: float | None = None) -> None:
        """Move to an end, or for some seconds; one that takes longer to its end than it may has failed."""
        self.direction = direction
        self._is_timed = seconds is not None
        self._left = self.timeout if seconds is None else seconds
        self._at = self._failed = 0

    def stop(self, at: int = 0) -> None:
        if self.direction:
            self.direction = 0
            self._at = at

    def advance(self, dt: float, place: float) -> None:
        """Take one step; `place` is 0 at the near end and 1 at the far one."""
        if self.direction > 0 and place > 1.0 - AT_END:
            self.stop(_FAR)
        elif self.direction < 0 and place < AT_END:
            self.stop(_NEAR)
        elif self.direction:
            self._left -= dt
            if self._left <= 0.0:
                self._failed = 0 if self._is_timed else _FAILED
                self.stop()


class GripperServer:
    """Firmware of the gripper; without one it only reports so.

    kind: as GRIPPERpac counts; 0 for none.
    """

    def __init__(self) -> None:
        self.kind = 0
        self._paddles = _Motor()
        self._lift = _Motor()
        self._gripper: GripperMechanism | None = None
        self.power_on()

    def fit(self, model: GripperModel) -> None:
        """A gripper is there."""
        self.kind = model.kind
        self._paddles.timeout = model.paddle_timeout_s
        self._lift.timeout = model.lift_timeout_s

    def power_on(self) -> None:
        """Begin as after the power switch."""
        self._paddles.power_on()
        self._lift.power_on()
        self._grasp_time = GRASP_TIME
        self._pressed = 0.0
        self._told: tuple[int, int] | None = None  # the machine may still do what it was told before
        self._awaits_value: GripperOrder | None = None

    @property
    def state(self) -> int:
        """The state byte of the SIP; 0 without a gripper."""
        return GripperFlags.of(self._paddles.nibble, self._lift.nibble) if self.kind else 0

    @property
    def inputs(self) -> int:
        """State of the gripper's switches, laid out as on the user I/O; moving motors are bits 6 and 7."""
        seen = self._seen
        switches = {
            GripperInput.PADDLES_BETWEEN: AT_END <= seen.opening <= 1.0 - AT_END,
            GripperInput.LIFT_BETWEEN: AT_END <= seen.lift <= 1.0 - AT_END,
            GripperInput.OUTER_BEAM: seen.outer_beam,
            GripperInput.INNER_BEAM: seen.inner_beam,
            GripperInput.LEFT_CONTACT: not seen.left_contact,
            GripperInput.RIGHT_CONTACT: not seen.right_contact,
            GripperInput.LIFT_MOVING: self._lift.direction,
            GripperInput.PADDLES_MOVING: self._paddles.direction,
        }
        return sum(int(switch) for switch, is_on in switches.items() if is_on)

    @property
    def second_byte(self) -> int:
        """Byte of the SIP after the state byte, in the place of the analog port.

        The state byte again, which some clients read there; on the general I/O the inputs, as one library expects.
        """
        return self.inputs if self.kind == GripperKind.PEOPLEBOT else self.state

    def report(self) -> GripperReport:
        """The GRIPPERpac of now."""
        return GripperReport(self.kind, self.state, self._grasp_time if self.kind else 0.0)

    def order(self, number: int) -> None:
        """GRIPPER; numbers that mean nothing are ignored."""
        if not self.kind or number not in _ORDERS:
            return
        order = GripperOrder(number)
        self._awaits_value = order if order in (GripperOrder.PRESS, GripperOrder.CARRY) else None
        _ORDERS[order](self)

    def value(self, number: int) -> None:
        """GRIPPERVAL, which belongs to the GRIPPER before it; out of its range it is ignored."""
        if self._awaits_value is GripperOrder.PRESS and 1 <= number <= LONGEST_PRESS:
            self._grasp_time = number * INTERVAL
        elif self._awaits_value is GripperOrder.CARRY and 1 <= abs(number) <= LONGEST_CARRY:
            self._lift.start(1 if number > 0 else -1, abs(number) * INTERVAL)
        self._awaits_value = None

    def halt(self) -> None:
        """Stop both motors; what is held stays held."""
        self._paddles.stop()
        self._lift.stop()

    def advance(self, gripper: GripperMechanism | None, dt: float) -> None:
        """Take one step; without a machine to drive, motors run into their timeouts."""
        self._gripper = gripper
        if self._paddles.direction or self._lift.direction:
            seen = self._seen
            self._paddles.advance(dt, seen.opening)
            self._lift.advance(dt, seen.lift)
            self._grasp(seen, dt)
        wanted = self._paddles.direction, self._lift.direction
        if gripper is not None and wanted != self._told:
            self._told = wanted
            gripper.drive(*wanted)

    @property
    def _seen(self) -> GripperMechanismState:
        return self._gripper.state if self._gripper else GripperMechanismState()

    def _grasp(self, seen: GripperMechanismState, dt: float) -> None:
        """Paddles that press on something from both sides go on for the grasp time, and are closed then."""
        if self._paddles.direction < 0 and seen.left_contact and seen.right_contact:
            self._pressed += dt
            if self._pressed >= self._grasp_time:
                self._paddles.stop(_NEAR)
        else:
            self._pressed = 0.0

    def _open(self) -> None:
        self._paddles.start(1)

    def _close(self) -> None:
        self._paddles.start(-1)

    def _raise(self) -> None:
        self._lift.start(1)

    def _lower(self) -> None:
        self._lift.start(-1)

    def _store(self) -> None:
        self._close()
        self._raise()

    def _deploy(self) -> None:
        self._open()
        self._lower()


_ORDERS: Mapping[GripperOrder, Callable[[GripperServer], None]] = {
    GripperOrder.OPEN: GripperServer._open,
    GripperOrder.CLOSE: GripperServer._close,
    GripperOrder.STOP: lambda server: server._paddles.stop(),
    GripperOrder.UP: GripperServer._raise,
    GripperOrder.DOWN: GripperServer._lower,
    GripperOrder.LIFT_STOP: lambda server: server._lift.stop(),
    GripperOrder.STORE: GripperServer._store,
    GripperOrder.DEPLOY: GripperServer._deploy,
    GripperOrder.HALT: GripperServer.halt,
    GripperOrder.PRESS: lambda server: None,
    GripperOrder.CARRY: lambda server: None,
}

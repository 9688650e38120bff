"""One axis of motion: a position servo whose target a profile moves."""

from math import copysign

from p2os_emu.microcontroller.profile import approach, braking_speed

REACTION = 0.1
"""s that a servo allows for between asking for a speed and having it: the last stretch to a target decays with it."""
TRIM = 0.4
"""1/s with which an error within the tolerance is trimmed away: at the rims too slow for a SIP to show."""
QUIET = 0.2
"""Of the tolerance: what is not even trimmed."""


class ServoLimits:
    """Working limits of one axis; m or rad, per second.

    top: what nothing exceeds. forward, backward: the most in either direction (SETV; SETRV, counter-clockwise and
    clockwise). acceleration, deceleration: of profiles, neither above acceleration_top. emergency: deceleration of an
    emergency stop.
    """

    __slots__ = ("acceleration", "acceleration_top", "backward", "deceleration", "emergency", "forward", "top")

    def __init__(
        self,
        *,
        top: float,
        fastest: float,
        acceleration: float,
        deceleration: float,
        acceleration_top: float,
        emergency: float,
    ) -> None:
        self.top = top
        self.forward = self.backward = min(fastest, top)
        self.acceleration = acceleration
        self.deceleration = deceleration
        self.acceleration_top = acceleration_top
        self.emergency = emergency

    def set_fastest(self, speed: float) -> None:
        """Limit both directions; the top still holds."""
        self.forward = self.backward = min(abs(speed), self.top)

    def set_fastest_one_way(self, speed: float) -> None:
        """Limit the direction that the sign names."""
        if speed < 0.0:
            self.backward = min(-speed, self.top)
        else:
            self.forward = min(speed, self.top)

    def set_acceleration(self, change: float) -> None:
        """Set the acceleration by a positive value, the deceleration by a negative one; zero is ignored."""
        if change > 0.0:
            self.acceleration = min(change, self.acceleration_top)
        elif change < 0.0:
            self.deceleration = min(-change, self.acceleration_top)

    def clip(self, speed: float) -> float:
        """The nearest speed that the limits allow."""
        return max(-self.backward, min(self.forward, speed))


class Servo:
    """Brings one axis to a speed or to a place, and holds it there.

    Given a speed, the profile leads there; given a target, it leads to the cruising speed, along and down to the place.
    At rest the servo holds its place, closed on the encoders.

    speed: what it asks of the wheels now, signed.
    """

    __slots__ = (
        "_anchor",
        "_cruise",
        "_emergency",
        "_goal",
        "_quiet",
        "_settled",
        "_tolerance",
        "limits",
        "speed",
        "target",
    )

    def __init__(self, limits: ServoLimits, tolerance: float) -> None:
        """Begin at rest.

        Args:
            limits: Read at every command, its accelerations at every step.
            tolerance: Distance from a target that is near enough.
        """
        self.limits = limits
        self._tolerance = tolerance
        self._quiet = tolerance * QUIET
        self._settled = tolerance / REACTION
        self.rest(0.0)

    @property
    def setpoint(self) -> float | None:
        """Where it goes to or stands; None while only a speed is asked for."""
        return self._anchor if self.target is None else self.target

    def rest(self, speed: float) -> None:
        """Forget every command.

        Args:
            speed: How fast the axis moves now; it is braked from there.
        """
        self.speed = speed
        self.target: float | None = None
        self._goal = 0.0
        self._cruise = 0.0
        self._anchor: float | None = None
        self._emergency = False

    def run(self, speed: float) -> None:
        """Go on at a speed, as far as the limits of this moment allow."""
        self.target = None
        self._goal = self.limits.clip(speed)
        self._emergency = False

    def go(self, start: float, distance: float) -> None:
        """Go to the place `distance` from `start`, cruising as fast as the limits of this moment allow."""
        self.target = start + distance
        self._cruise = self.limits.forward if distance >= 0.0 else self.limits.backward
        self._emergency = False

    def stop(self, emergency: bool = False) -> None:
        """Brake to a stand and hold it; in an emergency as hard as the axis can, which a plain stop does not soften."""
        self.target = None
        self._goal = 0.0
        self._emergency = self._emergency or emergency

    def restart(self, speed: float) -> None:
        """Go on with the same commands from another speed: the wheels had no power meanwhile."""
        self.speed = speed
        self._anchor = None

    def forget_place(self) -> None:
        """The scale of places has moved: stop going to one, and hold wherever the axis comes to stand."""
        if self.target is not None:
            self.stop()
        self._anchor = None

    def advance(self, place: float, speed: float, dt: float, halted: bool) -> float:
        """Take one step of the profile; return the speed that is asked of the wheels now.

        Args:
            place: Where the encoders see the axis.
            speed: How fast they see it move.
            dt: s.
            halted: Stand still now, but keep the commands.
        """
        target = self.target
        asked = self.speed
        if halted or (target is None and self._goal == 0.0):
            # Come to rest, and go back to where it came to rest.
            anchor = self._anchor
            if anchor is not None:
                goal = self._seek(anchor - place, self.limits.forward)
            else:
                goal = 0.0
                if asked == 0.0 and -self._settled < speed < self._settled:
                    self._anchor = place
        else:
            self._anchor = None
            goal = self._goal if target is None else self._seek(target - place, self._cruise)
        if goal == asked:
            return asked
        limits = self.limits
        braking = limits.emergency if self._emergency else limits.deceleration
        self.speed = asked = approach(asked, goal, limits.acceleration, braking, dt)
        return asked

    def _seek(self, remaining: float, cruise: float) -> float:
        """The speed towards a place, signed."""
        if -self._quiet <= remaining <= self._quiet:
            return 0.0
        if -self._tolerance <= remaining <= self._tolerance:
            return remaining * TRIM
        speed = braking_speed(abs(remaining), self.limits.deceleration, REACTION)
        return copysign(cruise if cruise < speed else speed, remaining)

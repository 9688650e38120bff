"""Mechanics of a camera head: pan, tilt and lens move to their targets."""

from math import inf

from p2os.accessories.head_model import HeadModel


class HeadServo:
    """A servo that moves at a set speed between two ends.

    position, target: in any unit. speed: of the motion, unit/s.
    """

    def __init__(self, lower: float, upper: float, speed: float) -> None:
        self.lower = lower
        self.upper = upper
        self.speed = speed
        self.position = self.target = min(max(0.0, lower), upper)

    @property
    def is_moving(self) -> bool:
        """Whether it has not reached its target."""
        return self.position != self.target

    def go(self, target: float) -> None:
        """Move to a position, limited by the ends."""
        self.target = min(max(target, self.lower), self.upper)

    def drive(self, direction: int) -> None:
        """Move to an end: -1 the lower, 1 the upper; 0 stops."""
        self.go(inf * direction if direction else self.position)

    def step(self, dt: float) -> None:
        """Let time pass, s."""
        way = self.target - self.position
        reach = self.speed * dt
        self.position = self.target if abs(way) <= reach else self.position + (reach if way > 0 else -reach)


class Head:
    """Pan (rad to the left), tilt (rad up) and lens (zoom counts)."""

    def __init__(self, model: HeadModel) -> None:
        self.model = model
        self.pan = HeadServo(*model.pan.limits, model.pan.top_speed)
        self.tilt = HeadServo(*model.tilt.limits, model.tilt.top_speed)
        self.lens = HeadServo(0.0, model.lens.counts, model.lens.counts / model.lens.travel_s)

    @property
    def zoom(self) -> float:
        """Magnification, 1 at the widest."""
        return self.model.lens.ratio_at(self.lens.position)

    @property
    def field_of_view(self) -> float:
        """Horizontal, rad."""
        return self.model.lens.field_of_view(self.zoom)

    @property
    def is_turning(self) -> bool:
        """Whether pan or tilt move."""
        return self.pan.is_moving or self.tilt.is_moving

    def stop(self) -> None:
        """Stop pan and tilt where they are."""
        self.pan.drive(0)
        self.tilt.drive(0)

    def home(self) -> None:
        """Move to straight ahead at top speed."""
        for servo, axis in ((self.pan, self.model.pan), (self.tilt, self.model.tilt)):
            servo.speed = axis.top_speed
            servo.go(0.0)

    def step(self, dt: float) -> None:
        """Let time pass, s."""
        for servo in (self.pan, self.tilt, self.lens):
            servo.step(dt)

"""What to do next to fetch an object: search, approach, grip, carry, put down. No bus, no clock."""

from collections.abc import Callable
from math import hypot, pi

from apps.fetch.driving import FetchDriving
from apps.fetch.floor import Disc, FetchFloor
from apps.fetch.hands import Hand
from apps.fetch.objects import FloorObject, FloorObjects
from apps.fetch.settings import FetchSettings
from apps.fetch.states import FetchOrders, FetchReadings, FetchState, HandState
from geometry import Point, Pose2D, Twist2D

_REST = Twist2D()
_ROOM = 0.12  # m before the hull, from which on an echo stops a straight approach
_HALF_TURN = 1.75 * pi  # rad that it turns to look about
_AGAIN = 3.0  # s after which an order to a hand that rests elsewhere is repeated
_CLEARED = 0.35  # m about an object, from where a sonar cone's echo of it may seem to come
_DOUBT = 0.03  # m, of heights
_HELD = 0.9, 0.2  # m ahead and to each side, where the camera sees what is held, taken for something on the floor
_SEEN_FOR = 2.0  # s without a sighting from the standoff, after which the object is gone
_HOLDING = frozenset(
    (
        FetchState.GRIP,
        FetchState.LIFT,
        FetchState.CARRY,
        FetchState.TURN_BACK,
        FetchState.DELIVER,
        FetchState.LOWER,
        FetchState.RELEASE,
    )
)
_CARRYING = frozenset((FetchState.CARRY, FetchState.TURN_BACK, FetchState.DELIVER))
_SEEING = frozenset((FetchState.SEARCH, FetchState.WANDER, FetchState.APPROACH, FetchState.ALIGN, FetchState.CARRY))
_WAITING = frozenset((FetchState.ALIGN, FetchState.GRIP, FetchState.LIFT, FetchState.LOWER, FetchState.RELEASE))
_NEARING = frozenset((FetchState.APPROACH, FetchState.ALIGN, FetchState.ADVANCE))
_ENDED = frozenset((FetchState.DELIVERED, FetchState.GIVEN_UP))


class Fetcher:
    """Decides for one robot and one kind of object.

    objects, floor: kept up by who has the images and the sonar.
    """

    def __init__(self, settings: FetchSettings, colour: str, place: Point, hand: Hand) -> None:
        """Begin.

        Args:
            settings: Of the application.
            colour: Of the object.
            place: Where it is to stand, m in odom.
            hand: What it grips with.
        """
        self.settings = settings
        self.hand = hand
        self.colour, self.place = colour, place
        self.objects, self.floor = FloorObjects(settings), FetchFloor(settings)
        self.state, self.reason = FetchState.SEARCH, f"no {colour} object is known yet"
        self.target: FloorObject | None = None
        self.attempts = 0
        self._turned_back = 0  # times, with the object
        self._now = self._since = self._advanced = 0.0
        self._searched: float | None = None  # since when it searches, or s after the last grip
        self._is_facing = False  # the place, since it delivers
        self._is_deployed = False  # since it stands before the object
        self._told = self._ordered = ""
        self._ordered_at = 0.0
        self._driving = FetchDriving(settings, self.floor)
        self._looked_from: list[Point] = []
        self._images = 0
        self._advance_from = Pose2D()
        self._back_from: Pose2D | None = None  # until it backs off
        self._next: Callable[[], None] = self._search
        self._steps: dict[FetchState, Callable[[FetchReadings, HandState], Twist2D]] = {
            FetchState.SEARCH: self._step_search,
            FetchState.WANDER: self._step_wander,
            FetchState.APPROACH: self._step_approach,
            FetchState.ALIGN: self._step_align,
            FetchState.ADVANCE: self._step_advance,
            FetchState.GRIP: self._step_grip,
            FetchState.LIFT: self._step_lift,
            FetchState.CARRY: self._step_carry,
            FetchState.TURN_BACK: self._step_back,
            FetchState.DELIVER: self._step_deliver,
            FetchState.LOWER: self._step_lower,
            FetchState.RELEASE: self._step_release,
            FetchState.BACK_OFF: self._step_back,
            FetchState.RETRY: self._step_back,
        }

    @property
    def has_ended(self) -> bool:
        """Whether nothing more is to be done."""
        return self.state in _ENDED

    def ignored(self, robot: Pose2D) -> tuple[Disc, ...]:
        """Return where echoes of sonar are those of the object that is gripped or held."""
        target, body = self.target, self.settings.robot
        if self.state in _CARRYING and body.lift_m > body.sonar_m + _DOUBT:
            return ()  # it is above the sonar
        lift = body.lift_m if self.state in _HOLDING else 0.0
        if target is None or target.height + lift < body.sonar_m - _DOUBT:
            return ()
        if self.state in _NEARING:
            return (Disc(target.x, target.y, target.width / 2.0),)
        return (Disc(*robot.transform(body.grip_m, 0.0), target.width / 2.0),) if self.state in _HOLDING else ()

    def is_held(self, x: float, y: float) -> bool:
        """Return whether something seen at a point of the floor, m in base_link, is in the hand."""
        return self.state in _HOLDING and x < _HELD[0] and abs(y) < _HELD[1]

    def lose_place(self) -> None:
        """Give up because odometry begins elsewhere, so that no place is known any more."""
        if not self.has_ended:
            held = "; the robot holds the object" if self.state in _HOLDING else ""
            self._give_up(f"odometry has begun anew, as after a restart of the gateway, and no place is known{held}")

    def step(self, readings: FetchReadings) -> FetchOrders:
        """Decide once."""
        self._now = readings.time
        if self._searched is None:
            self._searched = self._since = readings.time
            self._driving.begin(readings.time)
        self._driving.feel(readings.pose)
        state = self.state
        if readings.blind and state in _SEEING:
            self._driving.pause(readings.time)
            twist, words = _REST, f"stands: {readings.blind}"
        elif self.has_ended:
            twist, words = _REST, self.reason
        elif readings.hand is None:
            twist, words = _REST, f"stands: the {self.hand.element} has not reported yet"
        else:
            twist = self._steps[state](readings, readings.hand)
            words = self.reason
            self._order_again(readings.hand)
        changed = self.state is not state or words != self._told
        self._told = words
        twist = twist if self.state is state else _REST
        return FetchOrders(twist, self.hand.motion(), self.state, words, changed)

    # --- search

    def _step_search(self, readings: FetchReadings, hand: HandState) -> Twist2D:
        if self._found(readings.pose):
            return _REST
        if self._now - (self._searched or 0.0) > self.settings.search.give_up_s:
            left = self.objects.left(self.colour)
            self._give_up(f"no {self.colour} object was found in {self.settings.search.give_up_s:.0f} s{left}")
            return _REST
        if self._driving.turned > _HALF_TURN:
            self._look_elsewhere(readings.pose)
            return _REST
        return self._driving.turn_about()

    def _step_wander(self, readings: FetchReadings, hand: HandState) -> Twist2D:
        if self._found(readings.pose):
            return _REST
        pose = readings.pose
        if self._driving.has_arrived(pose):
            self._search()
            return _REST
        if self._driving.is_stuck(self._now, pose):
            self._turn_back(pose, FetchState.RETRY, self._search, "there is no room on the way")
            return _REST
        return self._driving.along(self._now, pose, self.objects.discs(self.target))

    def _found(self, pose: Pose2D) -> bool:
        """Begin to approach the nearest object that can be fetched."""
        self.target = self.objects.to_fetch(self._now, self.colour, self.place, (pose.x, pose.y))
        if self.target is None:
            return False
        away = self.target.distance(pose.x, pose.y)
        self._go(FetchState.APPROACH, f"a {self.colour} object is {away:.1f} m away")
        return True

    def _look_elsewhere(self, pose: Pose2D) -> None:
        """Drive to a place from where it has not looked."""
        self._looked_from.append((pose.x, pose.y))
        way = self.floor.next_view(pose, self._looked_from, self.objects.discs())
        if way is None:
            self._search()
        else:
            self._go(FetchState.WANDER, f"no {self.colour} object is in sight")
            self._driving.way = way

    def _search(self) -> None:
        self._driving.look_about()
        if self.hand.covers:
            self._order("open")
        self.target = None
        self._go(
            FetchState.SEARCH, f"no {self.colour} object is known that can be fetched{self.objects.left(self.colour)}"
        )

    # --- to the object

    def _step_approach(self, readings: FetchReadings, hand: HandState) -> Twist2D:
        target, pose, grip = self.target, readings.pose, self.settings.grip
        if target is None or not self.objects.has(target):
            self._lose(f"the {self.colour} object is not where it was any more")
            return _REST
        if self._driving.is_plan_due(self._now):
            self.floor.clear(target.x, target.y, _CLEARED)
            self._plan(pose, (target.x, target.y), grip.standoff_m)
        if self._driving.way is None:
            if self._driving.waits(self._now, self.settings.drive.stuck_s / 2.0):
                self._leave("no free way leads to it")
            return _REST
        if self._driving.has_arrived(pose):
            self._go(FetchState.ALIGN, f"it stands {target.distance(pose.x, pose.y):.2f} m ahead")
            self._images = readings.images
            self._ordered, self._is_deployed = "", not self.hand.hides
            if self._is_deployed:
                self._order("deploy")
            return _REST
        if self._driving.is_stuck(self._now, pose):
            self.floor.bar(pose, self._driving.way)
            self._leave("it cannot be reached")
            return _REST
        discs = (*self.objects.discs(self.target), Disc(target.x, target.y, target.width / 2.0))
        return self._driving.along(self._now, pose, discs)

    def _step_align(self, readings: FetchReadings, hand: HandState) -> Twist2D:
        target, pose, grip = self.target, readings.pose, self.settings.grip
        if target is None or not self.objects.has(target):
            self._lose(f"the {self.colour} object is not where it was any more")
            return _REST
        if abs(pose.bearing_to(target.x, target.y)) > grip.facing_rad:
            self._images = readings.images
            return self._driving.turn_to(pose, (target.x, target.y))
        if self._now - max(target.seen_at, self._since) > _SEEN_FOR:
            self._lose(f"the {self.colour} object is not seen any more")
        elif not self._is_deployed:
            if readings.images - self._images >= grip.standoff_images:
                self._deploy(target)
        elif hand.fingers == "open" and hand.height == "down":
            if readings.images - self._images >= grip.standoff_images:
                self._advanced = target.distance(pose.x, pose.y) - self.settings.robot.grip_m
                self._advance_from = pose
                self._go(
                    FetchState.ADVANCE, f"it is straight ahead, {self._advanced:.2f} m from the {self.hand.element}"
                )
        elif self._waits_too_long(f"the {self.hand.element} did not open"):
            return _REST
        return _REST

    def _step_advance(self, readings: FetchReadings, hand: HandState) -> Twist2D:
        target, pose = self.target, readings.pose
        assert target is not None  # it was faced
        gone = hypot(pose.x - self._advance_from.x, pose.y - self._advance_from.y)
        ahead, aside = pose.locate(target.x, target.y)
        left, fingers = ahead - self.settings.robot.grip_m, self.hand.fingers
        if self.hand.is_between(hand, left):
            self._order("close")
            self._go(FetchState.GRIP, f"it is between the {fingers}")
        elif self.hand.misses(left, aside, target.width):
            self._miss(f"it is {100 * abs(aside):.0f} cm beside the {fingers}")
        elif gone > self._advanced + self.settings.grip.beyond_m:
            self._miss(f"no {self.colour} object came between the {fingers}")
        elif readings.has_stalled:
            self._miss("something blocks the robot")
        elif self.floor.echo_ahead(self._now, pose) < _ROOM + self.settings.robot.grip_m - self.settings.robot.front_m:
            self._miss("an obstacle is too near behind the object")
        else:
            return self._driving.straight_to(pose, (target.x, target.y), self._advanced - gone)
        return _REST

    def _step_grip(self, readings: FetchReadings, hand: HandState) -> Twist2D:
        if hand.holds:
            self._order("up")
            self._go(FetchState.LIFT, f"the {self.hand.element} holds it")
        elif hand.fingers == "closed" and self._now - self._since > 1.0:
            self._miss(f"the {self.hand.element} closed on nothing")
        elif self._waits_too_long(f"the {self.hand.element} did not close"):
            return _REST
        return _REST

    def _step_lift(self, readings: FetchReadings, hand: HandState) -> Twist2D:
        if not hand.holds:
            self._miss(f"the object slipped out of the {self.hand.element}")
        elif hand.height == "up" and self._now - self._since > 0.5:
            assert self.target is not None  # it was gripped
            self.objects.forget(self.target)
            self.floor.clear(self.target.x, self.target.y, _CLEARED)
            self._searched = self._now
            self._carry()
        else:
            self._waits_too_long("the object was not raised")
        return _REST

    def _deploy(self, target: FloorObject) -> None:
        """Bring a hand that hides the object to where it grips, once its size is known from near."""
        misfit = self.objects.misfit(target)
        if misfit:
            target.leave(misfit, self._now, self.settings.attempts)
            self._lose(f"the {self.colour} object is left: it {misfit}")
            return
        self._is_deployed = True
        self._order("deploy")

    # --- to the place

    def _step_carry(self, readings: FetchReadings, hand: HandState) -> Twist2D:
        pose, place = readings.pose, self.place
        if not hand.holds:
            self._miss("the object was lost on the way")
            return _REST
        if self._driving.is_plan_due(self._now):
            self._plan(pose, place, self.settings.place.standoff_m)
        if self._driving.way is None:
            if self._driving.waits(self._now, self.settings.drive.stuck_s):
                self._give_up(
                    f"no free way leads to the place ({place[0]:.2f}, {place[1]:.2f}); the robot holds the object"
                )
            return _REST
        if self._driving.has_arrived(pose):
            self._go(FetchState.DELIVER, f"the place is {hypot(place[0] - pose.x, place[1] - pose.y):.2f} m ahead")
            return _REST
        if self._driving.is_stuck(self._now, pose):
            self._turned_back += 1
            if self._turned_back > self.settings.attempts:
                self._give_up("the place cannot be reached; the robot holds the object")
            else:
                self._turn_back(pose, FetchState.TURN_BACK, self._carry, "there is no room on the way")
            return _REST
        return self._driving.along(self._now, pose, self.objects.discs(self.target))

    def _step_deliver(self, readings: FetchReadings, hand: HandState) -> Twist2D:
        pose, place = readings.pose, self.place
        ahead, _ = pose.locate(*place)
        left = ahead - self.settings.robot.grip_m
        self._is_facing = self._is_facing or abs(pose.bearing_to(*place)) < self.settings.grip.facing_rad
        if not hand.holds:
            self._miss("the object was lost on the way")
        elif not self._is_facing:
            return self._driving.turn_to(pose, place)
        elif left <= 0.005:
            self._order("down")
            self._go(FetchState.LOWER, "the object is over the place")
        elif self.floor.echo_ahead(self._now, pose) < _ROOM or readings.has_stalled:
            self._give_up("an obstacle is at the place; the robot holds the object")
        else:
            return self._driving.straight_to(pose, place, left)
        return _REST

    def _step_lower(self, readings: FetchReadings, hand: HandState) -> Twist2D:
        if hand.height == "down" and self._now - self._since > 0.5:
            self._order("open")
            self._go(FetchState.RELEASE, "the object stands on the floor")
        else:
            self._waits_too_long("the object was not lowered")
        return _REST

    def _step_release(self, readings: FetchReadings, hand: HandState) -> Twist2D:
        if hand.fingers == "open":
            self._next = self._finish
            self._go(FetchState.BACK_OFF, f"the {self.hand.element} is open")
        else:
            self._waits_too_long(f"the {self.hand.element} did not open")
        return _REST

    def _step_back(self, readings: FetchReadings, hand: HandState) -> Twist2D:
        pose = readings.pose
        begin = self._back_from = self._back_from or pose
        gone = hypot(pose.x - begin.x, pose.y - begin.y)
        if gone >= self.settings.grip.back_m or self._now - self._since > self.settings.grip.wait_s:
            self._next()
            return _REST
        if not self.hand.is_clear(hand):
            return _REST
        if not self.floor.is_free_behind(self._now, pose, 0.1):
            if gone > 0.2:  # clear of the object
                self._next()
            return _REST
        return Twist2D(-self.settings.drive.back_m_s, 0.0)

    # --- what several states need

    def _plan(self, pose: Pose2D, goal: Point, away: float) -> None:
        """Plan the way to a place that is so many m from a goal, from which the goal can be approached straight."""
        driving, discs = self._driving, self.objects.discs(self.target)
        driving.way = self.floor.standoff(pose, goal, away, self.settings.robot.grip_m, discs, driving.way)

    def _carry(self) -> None:
        self._go(FetchState.CARRY, f"the {self.hand.element} holds the object, and it is raised")

    def _turn_back(self, pose: Pose2D, state: FetchState, then: Callable[[], None], reason: str) -> None:
        """Back off from where the way is too narrow, and take another one."""
        assert self._driving.way is not None  # it is stuck on it
        self.floor.bar(pose, self._driving.way)
        self._next = then
        self._go(state, reason)

    def _order(self, order: str) -> None:
        self._ordered, self._ordered_at = order, self._now
        self.hand.order(order, self.target.height if self.target is not None else 0.0)

    def _order_again(self, hand: HandState) -> None:
        """Repeat the last order while a state waits for it and nothing moves: it may have been lost or refused."""
        rests = "moving" not in (hand.fingers, hand.height)
        if self._ordered and self.state in _WAITING and rests and self._now - self._ordered_at > _AGAIN:
            self._order(self._ordered)

    def _waits_too_long(self, trouble: str) -> bool:
        if self._now - self._since <= self.settings.grip.wait_s:
            return False
        self._give_up(f"{trouble} in {self.settings.grip.wait_s:.0f} s")
        return True

    def _leave(self, reason: str) -> None:
        """Do not fetch this object."""
        assert self.target is not None  # it was approached
        self.target.leave(reason, self._now, self.settings.attempts)
        self._lose(f"the {self.colour} object is left: {reason}")

    def _lose(self, reason: str) -> None:
        self._search()
        self.reason = reason

    def _miss(self, reason: str) -> None:
        """Count an attempt, back off, and search again."""
        self.attempts += 1
        if self.target is not None:
            self.objects.forget(self.target)
            self.target = None
        self._order("open")
        if self.attempts >= self.settings.attempts:
            self._give_up(f"{reason}, {self.attempts} times")
            return
        self._next = self._search
        self._go(FetchState.RETRY, reason)

    def _finish(self) -> None:
        self._go(FetchState.DELIVERED, f"the {self.colour} object stands at ({self.place[0]:.2f}, {self.place[1]:.2f})")

    def _give_up(self, reason: str) -> None:
        self._go(FetchState.GIVEN_UP, reason)

    def _go(self, state: FetchState, reason: str) -> None:
        self.state, self.reason = state, reason
        self._since, self._is_facing, self._back_from = self._now, False, None
        self._driving.begin(self._now)

"""When a component is awake: while it has work, and while a program subscribes to the data that it makes on demand.

Readings are pulled: a component subscribes to its inputs only while it is awake, and this subscription wakes the
component that publishes them, down to the gateway. Orders are pushed: a goal, a piece of a plan, a command or a query
wakes its receiver. A component that sleeps waits for these alone, and has no timer that expires.
"""

import asyncio
from collections.abc import Callable
from math import inf

from apps.indoor_navigation.data import RobotOdometry
from bus import Bus, Sample, Subscription
from bus.aio import hand_over

LINGER = 5.0  # s awake after the last work: several times the period of repeated orders, and the robot stands for sure
CHECK_PERIOD = 0.5  # s between two checks of a component that is awake whether it may sleep
MOVING, TURNING = 0.01, 0.03  # m/s and rad/s above which a robot moves; below, gyro and odometry drift


class Inputs(Subscription):
    """The subscriptions of a component that are open only while it is awake."""

    def __init__(self, bus: Bus) -> None:
        self._bus = bus
        self._wanted: list[tuple[str, Callable[[Sample], None]]] = []
        self._open: list[Subscription] = []
        self._is_awake = self._is_closed = False

    def add(self, key: str, take: Callable[[Sample], None]) -> None:
        """Subscribe to a key while the component is awake. take: called with each sample on the thread of the bus."""
        self._wanted.append((key, take))
        if self._is_awake:
            self._subscribe(key, take)

    def open(self) -> None:
        """Open all subscriptions."""
        self._is_awake = True
        for key, take in self._wanted:
            self._subscribe(key, take)

    def shut(self) -> None:
        """Close all subscriptions until they are opened again."""
        self._is_awake = False
        while self._open:
            self._open.pop().close()

    def close(self) -> None:
        """Close all subscriptions for good."""
        self._is_closed = True
        self.shut()

    def _subscribe(self, key: str, take: Callable[[Sample], None]) -> None:
        if not self._is_closed:
            self._open.append(self._bus.subscribe(key, take, urgent=True))


class Wakefulness:
    """Whether a component is awake. All times are s of the event loop.

    woke_at: when it last woke up. slept: duration of the sleep before that, s.
    """

    def __init__(
        self, is_wanted: Callable[[], bool], on_wake: Callable[[], None], on_sleep: Callable[[], None]
    ) -> None:
        """Create it asleep, in the running event loop.

        Args:
            is_wanted: Returns whether the component must stay awake although its last work was long ago.
            on_wake: Called when it wakes up.
            on_sleep: Called when it falls asleep.
        """
        self.woke_at = self._slept_at = -inf
        self.slept = inf
        self._is_wanted, self._on_wake, self._on_sleep = is_wanted, on_wake, on_sleep
        self._loop = asyncio.get_running_loop()
        self._busy_until = -inf
        self._awake = asyncio.Event()

    @property
    def is_awake(self) -> bool:
        """Whether the component is awake."""
        return self._awake.is_set()

    def work(self) -> None:
        """Wake up, and stay awake for `LINGER` seconds at least."""
        self._busy_until = self._loop.time() + LINGER
        self._wake()

    def look(self) -> None:
        """Wake up if the component is wanted."""
        if self._is_wanted():
            self._wake()

    def call(self, what: Callable[[], None]) -> None:
        """Call `work` or `look` in the event loop, from any thread."""
        hand_over(self._loop, what)

    async def awake(self) -> None:
        """Wait until the component is awake."""
        await self._awake.wait()

    async def rest(self) -> None:
        """Wait until there is nothing to do any more, and fall asleep."""
        await self._awake.wait()
        while self._loop.time() < self._busy_until or self._is_wanted():
            await asyncio.sleep(CHECK_PERIOD)
        self._slept_at = self._loop.time()
        self._awake.clear()
        self._on_sleep()
        self.look()  # somebody may have subscribed since the check

    def _wake(self) -> None:
        if not self._awake.is_set():
            self.woke_at = self._loop.time()
            self.slept = self.woke_at - self._slept_at
            self._on_wake()
            self._awake.set()


def moves(odometry: RobotOdometry) -> bool:
    """Return whether the robot moves."""
    return abs(odometry.linear) > MOVING or abs(odometry.angular) > TURNING

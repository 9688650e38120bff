"""One browser at a time drives a robot, with the leases on it.

The browser sends its command again and again while it is in control, and each command carries the latest time that the
console has sent to it (`tick`). So the age of a command is known without a clock of the browser: a command that waited
in a network, or in a browser that was frozen, is older than `old_s` and is not obeyed. When the commands cease the
robot is stopped, and when that lasts, the leases are released. If this program dies or freezes, `cmd_vel` is silent and
the gateway stops the robot.
"""

import asyncio
from collections.abc import Callable, Iterable
from contextlib import AsyncExitStack
from dataclasses import dataclass
from typing import Any, Self

from agents.platform import Agent, RequestNotDone
from agents.platform.errors import in_words
from agents.services.lease_client import HeldLease, leased
from agents.services.leases import LeaseNews
from apps.console.settings import DriverLimits
from apps.console.visits import Visit
from bus import BusError, keys
from bus.messages import twist

BASE = "base"
DRIVEN = (BASE, "arm", "gripper")
"""Elements on which whoever drives has the leases, as far as the robot has them; the camera head has its own."""
_ZEROS = 3  # stops that are sent one after the other; afterwards `cmd_vel` is silent, so that a held stop can end

Say = Callable[[Visit, str], None]
"""Shows a page what has happened, a sentence."""


@dataclass(frozen=True, slots=True)
class DriveCommand:
    """A command of a browser.

    tick: s of the console's time, as the browser got it last. linear, angular: parts of the chosen speeds, -1 to 1.
    """

    tick: float
    linear: float
    angular: float

    @classmethod
    def from_json(cls, told: Any) -> Self | None:
        """Read what a browser sends; None for anything else."""
        match told:
            case {"tick": int() | float() as tick, "linear": int() | float() as v, "angular": int() | float() as w}:
                is_number = not any(isinstance(value, bool) for value in (tick, v, w))
                if is_number and all(-1.0 <= part <= 1.0 for part in (v, w)):  # false for NaN as well
                    return cls(float(tick), float(v), float(w))
        return None

    @property
    def is_neutral(self) -> bool:
        """Whether it is to stand."""
        return self.linear == 0.0 and self.angular == 0.0


class DriveControl:
    """The wheels of one robot, and the page that drives.

    robot: its name. holder: the page in control; None for nobody. speeds: m/s and rad/s of the whole deflection.
    """

    def __init__(self, agent: Agent, robot: str, limits: DriverLimits, say: Say) -> None:
        """Begin without a driver.

        Args:
            agent: Holds the leases.
            robot: Its name.
            limits: Settings.
            say: Called with what a page needs to know.
        """
        self.robot = robot
        self.holder: Visit | None = None
        self.speeds = (limits.linear, limits.angular)
        self._agent, self._limits, self._say = agent, limits, say
        self._leases: dict[str, HeldLease] = {}
        self._letting_go = AsyncExitStack()
        self._changing = asyncio.Lock()
        self._heard_at = 0.0  # s of the loop's time of the latest command that was young enough
        self._is_latched = False  # until a young command that is neutral
        self._zeros = _ZEROS  # stops sent since the last motion
        self._wheels = agent.bus.publisher(keys.CMD_VEL.key(robot), keys.CMD_VEL.type_name)

    @property
    def is_latched(self) -> bool:
        """Whether the robot was stopped since its driver fell silent, and is not driven until that lets go."""
        return self._is_latched

    def token(self, element: str) -> str:
        """Return the token of the lease on an element; empty without one."""
        lease = self._leases.get(element)
        return lease.token if lease is not None else ""

    async def take(self, visit: Visit, elements: Iterable[str], now: float) -> None:
        """Give a page control if nobody has it.

        Args:
            visit: The page.
            elements: That the robot has.
            now: s of the console's time.
        """
        async with self._changing:
            if self.holder is visit:
                return
            if self.holder is not None:
                self._say(visit, f"{self.holder.name} drives {self.robot}; ask for it to be released")
                return
            there = {BASE, *elements}
            wanted = [name for name in DRIVEN if name in there]
            try:
                for name in wanted:
                    place = f"{name}@{self.robot}"
                    self._leases[name] = await self._letting_go.enter_async_context(
                        leased(self._agent, place, seconds=self._limits.lease_s, on_news=self._hear)
                    )
            except (RequestNotDone, BusError) as err:
                await self._let_go()
                self._say(visit, f"no control of {self.robot}: {in_words(err)}")
                return
            if not visit.may_command:  # its session has ended while the leases were asked for
                await self._let_go()
                self._say(visit, f"no control of {self.robot}: {visit.look_only}")
                return
            self.holder = visit
            self._is_latched, self._zeros = True, _ZEROS
            self._heard_at = now
            self._say(visit, f"you drive {self.robot}")

    async def release(self, why: str = "released") -> None:
        """Stop the robot, and give the leases back."""
        self.halt()
        async with self._changing:
            holder, self.holder = self.holder, None
            if holder is None:
                return
            holder.cancel_motions()
            await self._let_go()
            self._say(holder, f"you do not drive {self.robot} any more: {why}")

    def drive(self, visit: Visit, command: DriveCommand, now: float) -> str:
        """Carry out a command of a page at a time, s; return why it is not obeyed, empty if it is."""
        if self.holder is not visit:
            return "take control first"
        age = now - command.tick
        if not 0.0 <= age <= self._limits.old_s:
            self.latch()
            return f"the command is {max(age, 0.0):.1f} s old and was not obeyed"
        self._heard_at = now
        if self._is_latched:
            if not command.is_neutral:
                return "let go first: the robot was stopped"
            self._is_latched = False
        if (by := self._wanted_by) and not command.is_neutral:
            self.halt()
            return f"{by} is about to take control"
        if command.is_neutral:
            self.halt()
        else:
            self._zeros = 0
            self._publish(command.linear * self.speeds[0], command.angular * self.speeds[1])
        return ""

    def halt(self) -> None:
        """Stop the wheels, unless they have been stopped already."""
        if self._zeros < _ZEROS:
            self._zeros += 1
            self._publish(0.0, 0.0)

    def latch(self) -> None:
        """Stop the robot until its driver has let go, since a person or an emergency stop has stopped it."""
        self.halt()
        self._is_latched = True

    async def check(self, now: float) -> None:
        """Stop the robot if the driver is silent at a time, s, and release the leases if that lasts. Call it often."""
        if (holder := self.holder) is None:
            return
        if any(not lease.is_held for lease in self._leases.values()):
            news = next((lease.news for lease in self._leases.values() if not lease.is_held), None)
            await self.release(f"the lease is lost ({news or 'it was not renewed'})")
            return
        silence = now - self._heard_at
        if silence > self._limits.silent_s or not holder.sockets:
            self.halt()
            if not self._is_latched:
                self._is_latched = True
                holder.cancel_motions()
        if silence > self._limits.release_s:
            await self.release(f"the browser has sent nothing for {silence:.0f} s")

    async def close(self) -> None:
        """Stop the robot and release the leases at the end of the program."""
        await self.release("the console ends")
        self._wheels.close()

    @property
    def _wanted_by(self) -> str:
        return next((lease.wanted_by for lease in self._leases.values() if lease.wanted_by), "")

    def _publish(self, linear: float, angular: float) -> None:
        self._wheels.put(twist(linear, angular), self.token(BASE).encode())

    async def _let_go(self) -> None:
        letting_go, self._letting_go, self._leases = self._letting_go, AsyncExitStack(), {}
        await letting_go.aclose()

    def _hear(self, news: LeaseNews) -> None:
        if self.holder is not None and news.is_warning:
            self._say(self.holder, f"{news.by} takes control of {self.robot} in {news.within:.1f} s")

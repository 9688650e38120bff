"""The base class of the driver's side of elements on the robot's line.

An element asks the robot for its packets, takes them, and gives commands; the driver lends it the cable. What it finds
out it announces as an event of `gateway.events`; its bus adapter brings the event to the bus. Bytes and time
are arguments here as in the driver.
"""

from collections.abc import Callable, Hashable, Sequence
from math import inf
from typing import ClassVar, Generic, TypeVar

from gateway.events import Event
from gateway.outbox import Outbox
from gateway.settings import Settings
from p2os import Command, CommandValue, Configuration, RobotModel, StandardSip, encode_command

P = TypeVar("P", contravariant=True)
"""The packets that an element takes."""
REPEAT = 0.15
"""Seconds after which an element that still moves is told to stop again."""
BELIEVED = 1.0
"""Seconds after which a report of rest is believed; one before may be older than the motion."""


class RepeatedStop:
    """Says when an element is to be told again to stop: the robot confirms no frame, and one may be lost."""

    def __init__(self) -> None:
        """Nothing was stopped yet."""
        self._is_wanted = False
        self._since: float | None = None
        self._told_at = 0.0

    def begin(self) -> None:
        """Note that the element was told to stop."""
        self._is_wanted, self._since = True, None

    def end(self) -> None:
        """Note that the element has a newer order."""
        self._is_wanted = False

    def is_due(self, is_moving: bool, now: float) -> bool:
        """Take a report of the element; return whether to tell it again. now: steady time, s."""
        if not self._is_wanted:
            return False
        if self._since is None:
            self._since = self._told_at = now
        if not is_moving:
            self._is_wanted = now - self._since < BELIEVED
            return False
        if now - self._told_at < REPEAT:
            return False
        self._told_at = now
        return True


class Element(Generic[P]):
    """One element of a robot.

    takes: the classes of the packets that it takes.
    is_present: the robot is known to have it; only then it is announced, and obeys commands.
    deadline: when `watch` is due even if nothing has come, s.
    """

    takes: ClassVar[tuple[type, ...]] = ()

    def __init__(self, outbox: Outbox, announce: Callable[[Event], None], settings: Settings) -> None:
        """Prepare the element.

        Args:
            outbox: Takes frames for the robot; one of a kind still waiting is replaced.
            announce: Takes events, in order.
            settings: Of this robot.
        """
        self._outbox = outbox
        self._announce = announce
        self._settings = settings
        self._stop = RepeatedStop()  # of those that move
        self.is_present = False
        self.deadline = inf

    @property
    def faults(self) -> Sequence[str]:
        """What is wrong with it, a sentence each; asked while the robot is connected."""
        return ()

    def begin_link(self, model: RobotModel, now: float) -> None:
        """Request what is needed from a robot that has just been opened."""

    def configure(self, configuration: Configuration, now: float) -> None:
        """Take the robot's CONFIGpac."""

    def meet_simulator(self, now: float) -> None:
        """Note that the robot is simulated; called after `begin_link`, at most twice for each link."""

    def lose_link(self) -> None:
        """Note that the robot is lost."""

    def see(self, sip: StandardSip, now: float) -> None:
        """Take a plausible SIP."""

    def take(self, packet: P, now: float) -> None:
        """Take a packet of one of the classes in `takes`."""

    def watch(self, now: float) -> None:
        """Do what is due at this time, s."""

    def halt(self, now: float) -> None:
        """Stop where it is, because the robot was stopped. Does nothing for an element that cannot move."""

    def is_moving(self, now: float) -> bool:
        """Return whether it moves by motors of its own, by its last report."""
        return False

    def _ask(self, command: Command, value: CommandValue | None = None, kind: Hashable = None) -> None:
        """Queue a command that can wait until those that move the robot have left.

        Args:
            command: Which.
            value: Its argument, as `encode_command` takes it.
            kind: What it replaces while it waits; by itself those of the same number.
        Raises:
            EncodeError: The value does not fit the command's argument.
        """
        self._outbox.ask(command if kind is None else kind, encode_command(command, value))

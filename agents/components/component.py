"""The base class of the agents of elements: they serve requests about the element, and publish its readings.

    class Battery(Component):
        source = keys.BATTERY
        results = {"voltage": "V", ...}

        def result(self, message):
            return {"voltage": message.voltage, ...}

A reading is decoded only if a program subscribes to the results or requests it, or if a motion follows it.
"""

import asyncio
from collections import deque
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from math import isfinite
from typing import Any, ClassVar

from agents.platform import Agent, AgentName, AgentState, OneShot, Restart, agree, attended, request
from agents.platform.stream import Stream
from bus import BusUnavailable, Conversation, MessageError, NoAnswer, Refused, Sample, TimedOut
from bus.aio import ReplyQueue, hand_over
from bus.keys import Topic
from bus.messages import NS_PER_S, stamp_ns

COMMAND_TIME = 2.0  # s for the gateway to answer
MOST_UNREAD = 64  # messages kept where a result is made of several


class ElementAgent(Agent):
    """The agent of one element: its local name is the element's, its platform is the robot.

    source: the stream from which results are made. None if there is none, or if the class calls `renew` itself.
    memory: s of messages before the latest one from which a result is made as well.
    fresh: s for which a reading is valid.
    first_within: s that `read` waits for the first reading.
    results: fields of its results beside `stamp`, with units, for the documentation.
    """

    source: ClassVar[Topic | None] = None
    memory: ClassVar[float] = 0.0
    fresh: ClassVar[float] = 3.0
    first_within: ClassVar[float] = 2.0
    results: ClassVar[Mapping[str, str]] = {}

    def __init__(self, name: AgentName | str, properties: Mapping[str, Any] | None = None) -> None:
        super().__init__(name, properties)
        self._latest: Mapping[str, Any] | None = None
        # Newer than the latest result, and not decoded yet. The bus's thread appends, the loop takes.
        self._unread: deque[tuple[Sample, float]] = deque(maxlen=MOST_UNREAD if self.memory else 1)
        self._heard_at = 0.0  # s of the loop's time, when the latest result came
        self._has_heard = asyncio.Event()
        self._stream: Stream | None = None

    @classmethod
    def properties_of(cls, robot: Mapping[str, Any], element: Mapping[str, Any]) -> dict[str, Any]:
        """Return the properties of the agent: the description of its element.

        Args:
            robot: The description of the robot.
            element: The element's row in it.
        """
        about = {
            "robot_model": robot.get("model"),
            "robot_class": robot.get("class"),
            "emulated": robot.get("emulated"),
        }
        return {**{key: value for key, value in element.items() if key != "name"}, **about}

    @property
    def robot(self) -> str:
        """The robot's name on the bus."""
        return self.name.platform

    @property
    def element(self) -> str:
        """The element's name in the robot's description."""
        return self.name.local

    def describe(self) -> dict[str, Any]:
        """Return its description for the directory, with the services `component` and the element's name."""
        return {**super().describe(), "services": [self.element, "component", *self.services]}

    async def setup(self) -> None:
        """Subscribe to the source."""
        topic = self.topic
        if topic is not None:
            key = topic.key(self.robot)
            self._stream = Stream(key, self._hear, 1, self._malformed)
            self.add(self._stream, Restart())
            self._begin_to_hear(key)
        if self.has_readings:
            self._open.append(self.bus.converse(self.name.results_key, self._take_look, urgent=True))

    def _begin_to_hear(self, key: str) -> None:
        """Subscribe to the source's messages."""
        self._open.append(self.bus.subscribe(key, self._take_sample, urgent=True))

    @property
    def has_readings(self) -> bool:
        """Whether it has readings."""
        return self.topic is not None or bool(self.results)

    @property
    def topic(self) -> Topic | None:
        """The stream from which results are made."""
        return self.source

    @property
    def is_eager(self) -> bool:
        """Whether every message becomes a result now, beside those that are requested or subscribed to; any thread."""
        return False

    def result(self, message: Any) -> Mapping[str, Any]:
        """Return the result of a message of the source; SI units and radians, None where nothing was measured."""
        raise NotImplementedError

    def renew(self, result: Mapping[str, Any]) -> None:
        """Keep a new result for `read`, and publish it."""
        self._unread.clear()
        self._latest = result
        self._heard_at = asyncio.get_running_loop().time()
        self._has_heard.set()
        if self.is_heard:
            self.publish(result)

    @request("read")
    async def read(self) -> dict[str, Any]:
        """The latest result; fails where there is none, or an old one only."""
        if not self.has_readings:
            raise Refused(f"{self.name} has no readings")
        if not self._has_heard.is_set():
            try:
                async with asyncio.timeout(self.first_within):
                    await self._has_heard.wait()
            except TimeoutError:
                raise failure(f"{self.name} has heard nothing yet") from None
        return self.latest()

    def latest(self) -> dict[str, Any]:
        """Return the latest result.

        Raises:
            Refused: There is none, or it is too old.
        """
        self._read_waiting()
        if self._latest is None:
            raise failure(f"{self.name} has heard nothing yet")
        silence = asyncio.get_running_loop().time() - self._heard_at
        if silence > self.fresh:
            raise failure(f"{self.name} has heard nothing for {silence:.1f} s")
        return dict(self._latest)

    @contextmanager
    def commanding_motion(self) -> Iterator[str | None]:
        """Bind a motion to its initiator during a block that begins it and waits for its end.

        The handler is cancelled when the initiator's heartbeat stops, and this agent publishes its own heartbeat.

        Yields:
            The heartbeat to which the gateway's command is to be bound; None where the initiator has none, so that the
            gateway carries out short motions only.
        """
        with attended() as has_heartbeat, self.home.beating(self.name):
            yield self.name.heartbeat_key if has_heartbeat else None

    async def command(self, topic: Topic, /, **arguments: Any) -> dict[str, Any]:
        """Send a command to the robot's gateway; an argument that is None is left out, and so is an empty token.

        Raises:
            Refused: The gateway refuses, or there is none.
        """
        given = {
            name: value for name, value in arguments.items() if value is not None and (name, value) != ("token", "")
        }
        try:
            replies = ReplyQueue(COMMAND_TIME)
            with self.bus.ask(topic.key(self.robot), given, replies.put, replies.put, COMMAND_TIME, urgent=True):
                answers = [reply.value async for reply in replies]
            return answers[0]
        except TimeoutError as err:
            if isinstance(err, NoAnswer) and not isinstance(err, TimedOut):
                raise Refused(f"nobody drives {self.robot}; see whether its p2os-gateway runs") from err
            raise failure(f"the gateway of {self.robot} has not answered within {COMMAND_TIME:g} s") from err

    def _made_of(self, message: Any) -> dict[str, Any]:
        return {"stamp": stamp_ns(message.header) / NS_PER_S, **self.result(message)}

    def _read_waiting(self) -> None:
        """Make the result of the messages that were not decoded yet; older ones that cannot be decoded are left out.

        Raises:
            Refused: The latest one cannot be decoded.
        """
        oldest = self._unread[-1][1] - self.memory if self._unread else 0.0
        while self._unread:
            sample, at = self._unread.popleft()
            if at < oldest:
                continue
            try:
                self._latest, self._heard_at = self._made_of(Stream.decode(sample)), at
            except MessageError as err:
                if not self._unread:
                    raise failure(f"{self.name} cannot read what it hears: {err}") from err

    def _begin_look(self, conversation: Conversation) -> None:
        if self.state is AgentState.SUSPENDED:
            conversation.refuse(f"{self.name} is suspended")
        else:
            self.add(OneShot(lambda: self._show_reading(conversation), "show its latest result"))

    async def _show_reading(self, conversation: Conversation) -> None:
        with conversation, suppress(BusUnavailable):  # the client may have gone
            try:
                conversation.reply(await self.read())
            except Refused as err:
                conversation.refuse(err.why)

    async def _hear(self, message: Any) -> None:
        if self.memory:
            with suppress(Refused):  # this message is newer
                self._read_waiting()
        self.renew(self._made_of(message))

    def _malformed(self, error: Exception) -> None:
        self.home.report(self.name, "a message is left out", error)

    # On the bus's thread, so that a message that is not used costs almost nothing.

    def _take_look(self, arguments: dict[str, Any], conversation: Conversation) -> None:
        """Answer a query for the latest reading, from a program that may only read."""
        assert self._loop is not None
        hand_over(self._loop, self._begin_look, conversation)

    def _take_sample(self, sample: Sample) -> None:
        """Take a sample of the source."""
        assert self._loop is not None
        assert self.topic is not None
        if sample.type_name == self.topic.type_name:
            self._take_reading(sample)
        else:
            wrong = MessageError(f"{sample.key} carries {self.topic.type_name}, not {sample.encoding or 'bytes'}")
            hand_over(self._loop, self._malformed, wrong)

    def _take_reading(self, sample: Sample) -> None:
        """Take a message of the source."""
        assert self._loop is not None
        assert self._stream is not None  # it has been made before this was subscribed
        if self.is_eager or self.is_heard:
            self._stream.take(sample)
        else:
            self._unread.append((sample, self._loop.time()))
            if not self._has_heard.is_set():
                hand_over(self._loop, self._has_heard.set)


def failure(why: str) -> Refused:
    """Return the error that makes a request fail; it agrees first, so that the error is not a refusal."""
    with suppress(LookupError):  # there may be no current request
        agree()
    return Refused(why)


def known(value: float, digits: int = 4) -> float | None:
    """Return a measured number for a result, rounded to its accuracy; None if it is infinite or NaN."""
    return round(float(value), digits) if isfinite(value) else None

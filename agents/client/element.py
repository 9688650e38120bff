"""The client of one element of a robot: requests, readings and streams of readings."""

import asyncio
from collections.abc import Coroutine, Iterator, Mapping
from contextlib import closing, suppress
from numbers import Integral, Real
from typing import Any, ClassVar, Generic, TypeVar

from agents.client.errors import Failed, NotThere, RequestRefused, RequestTimedOut, RobotError, check_seconds
from agents.client.loop_thread import LoopThread
from agents.client.readings import OtherReading, Reading
from agents.client.wording import in_api_words
from agents.platform import AgentName, Ending, Outcome, Performative
from bus import MessageError, Sample, Subscription
from bus.aio import hand_over
from bus.payload import decode_json

PATIENCE = 10.0  # s for an answer, and for the next result of a stream

R = TypeVar("R", bound=Reading)


class ElementClient(Generic[R]):
    """Any element of a robot.

    agent: the name of its agent, `laser@happy`.
    """

    reading: ClassVar[type[Reading]] = OtherReading

    def __init__(self, thread: LoopThread, agent: AgentName) -> None:
        self.agent = agent
        self._thread = thread

    def ask(self, request: str, /, *, within: float = PATIENCE, **arguments: Any) -> Any:
        """Request anything from its agent, and wait for the end; `acromovi directory` lists the requests.

        Args:
            request: Its name, `read` for example.
            within: s to wait.
            arguments: JSON values by name.
        Returns:
            The agent's result, made of JSON; objects whose keys are all whole numbers have these as `int`.
        Raises:
            RobotError: It was not done; the class tells why.
        """
        return self._result_of(request, self._thread.call(self._requested(request, within, arguments)))

    def _requested(self, request: str, within: float, arguments: Mapping[str, Any]) -> Coroutine[Any, Any, Outcome]:
        """Return the coroutine of a request to the element's agent."""
        check_seconds("within", within)
        given = {name: plain(value) for name, value in arguments.items()}
        initiator = self._thread.agent.initiator
        return initiator.conversation(Performative.REQUEST, self.agent, request, given, within, within).outcome()

    def _result_of(self, request: str, outcome: Outcome) -> Any:
        if not outcome.is_done:
            raise _error_of(outcome, self.agent, request)
        return _numbered(outcome.result)

    def read(self, within: float = PATIENCE) -> R:
        """Return the latest reading; wait a little for the first.

        Args:
            within: s to wait for the answer.
        Raises:
            RobotError: There is none, or none that is fresh.
        """
        if self._thread.only_looks:
            return self._read(self._thread.call(self._thread.agent.query(self.agent.results_key, timeout=within)))
        return self._read(self.ask("read", within=within))

    @property
    def properties(self) -> dict[str, Any]:
        """Return what its agent describes of the element: limits, sizes and angles, by name.

        Raises:
            RobotError: The agent does not answer.
        """
        described = self._thread.call(self._thread.agent.query(self.agent.description_key))
        return dict(described.get("properties") or {})

    def watch(self, within: float = PATIENCE) -> Iterator[R]:
        """Yield every reading as it comes; older ones are dropped while the loop is busy.

        Args:
            within: s to wait for the next.
        Raises:
            NotThere: The element has gone.
            TimedOut: It has sent nothing for too long.
        """
        check_seconds("within", within)
        latest: asyncio.Queue[dict[str, Any]] = asyncio.Queue()
        with closing(self._thread.call(self._listen(latest))):
            while True:
                yield self._read(self._thread.call(self._next(latest, within)))

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.agent}>"

    async def _listen(self, latest: "asyncio.Queue[dict[str, Any]]") -> Subscription:
        bus = self._thread.agent.bus
        return bus.subscribe(self.agent.results_key, lambda sample: self._take(sample, latest), urgent=True)

    def _take(self, sample: Sample, latest: "asyncio.Queue[dict[str, Any]]") -> None:
        with suppress(MessageError):  # the next one is decoded again
            hand_over(self._thread.loop, _replace, latest, decode_json(sample.payload))

    async def _next(self, latest: "asyncio.Queue[dict[str, Any]]", within: float) -> dict[str, Any]:
        try:
            async with asyncio.timeout(within):
                return await latest.get()
        except TimeoutError as err:
            outcome = await self._thread.agent.request(self.agent, "read", reply_within=PATIENCE)
            if not outcome.is_done:
                raise _error_of(outcome, self.agent, "read") from err
            raise RequestTimedOut(f"{self.agent} has sent nothing for {within:g} s") from err

    def _read(self, result: Any) -> R:
        if not isinstance(result, dict):
            raise NotThere(f"{self.agent} says nothing that can be read")
        return self.reading.of(result, self.agent)  # type: ignore[return-value]  # R is what `reading` says


def plain(value: Any) -> Any:
    """Return what JSON can carry: plain numbers in place of NumPy's, and text in place of numbers as keys."""
    match value:
        case bool():
            return value
        case Integral():
            return int(value)
        case Real():
            return float(value)
        case Mapping():
            return {str(name): plain(item) for name, item in value.items()}
        case list() | tuple():
            return [plain(item) for item in value]
    return value


def _numbered(value: Any) -> Any:
    """Return the same with the numbers that JSON objects can have as text only: `{"3": 1.2}` becomes `{3: 1.2}`.

    An object is converted if it has keys, and if all of them are whole numbers as Python writes them.
    """
    match value:
        case dict():
            items = {name: _numbered(item) for name, item in value.items()}
            return {int(name): item for name, item in items.items()} if items and all(map(_is_number, items)) else items
        case list():
            return [_numbered(item) for item in value]
    return value


def _is_number(name: Any) -> bool:
    digits = str(name).removeprefix("-")
    return digits.isascii() and digits.isdecimal() and str(int(name)) == str(name) if digits else False


def _replace(latest: "asyncio.Queue[dict[str, Any]]", result: dict[str, Any]) -> None:
    while not latest.empty():
        latest.get_nowait()
    latest.put_nowait(result)


_BY_ENDING: dict[Ending, tuple[type[RobotError], str]] = {
    Ending.REFUSED: (RequestRefused, "{peer} refuses {request}: {why}"),
    Ending.NOT_UNDERSTOOD: (RequestRefused, "{peer} does not understand {request}: {why}"),
    Ending.NOT_ALLOWED: (RequestRefused, "{request} is not allowed: {why}"),
    Ending.FAILED: (Failed, "{peer} could not {request}: {why}"),
    Ending.TIMED_OUT: (RequestTimedOut, "{request}: {why}"),
    Ending.DIED: (NotThere, "{why}; see `acromovi ps` for who is there"),
}


def _error_of(outcome: Outcome, peer: object, request: str) -> RobotError:
    """Return the error for the outcome of a request, in the terms of this API."""
    kind, sentence = _BY_ENDING[outcome.ending]
    why = in_api_words(outcome.why, str(peer).partition("@")[0])
    return kind(sentence.format(peer=peer, request=request, why=why))

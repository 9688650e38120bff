"""The bus between processes and machines: a Zenoh session.

A profile is Zenoh's own configuration, in TOML with Zenoh's own names; the profiles are in `configs/bus`. A file in
Zenoh's format (`.json5`) can be used as well.
"""

import atexit
import contextlib
import json
import logging
import time
from collections.abc import Callable, Iterator, Mapping
from functools import cache, partial
from typing import Any, Self

import zenoh

from bus import threads
from bus.bus import JSON, QUERY_TIMEOUT, Answer, Bus, Publisher, Sample, Subscription
from bus.declared import Declared, LatestListening, Listening, Undeclarable
from bus.errors import BusError, BusUnavailable
from bus.exchange import (
    Answerer,
    MessageEncoder,
    Replies,
    Talker,
    answered,
    check_handler,
    guarded,
    key_expression,
    plain_key,
    reason,
)
from bus.handler_thread import HandlerThread
from bus.links import LinkWatch
from bus.loopback import LocalBus, Registration
from bus.payload import encode_json
from bus.scouting import Scouting
from bus.secure import ADMITTED, Permit, Profile
from bus.timers import Timers
from bus.zenoh_conversation import ConversationListening, ZenohQuery
from configs.defaults import default_bus
from configs.loader import ConfigError

log = logging.getLogger("bus")

# Queryables of other sessions become known some ms after opening. In a session younger than this, a query without a
# reply is sent again; the time is longer where not all connections could be opened yet, as on a busy machine. Who is
# not connected by then is taken to be frozen.
MEETING_TIME = 0.5  # s
LATE_MEETING_TIME = 2.5  # s
MOST_TRIES = 5  # to listen on a port that was free a moment before


def configuration(profile: str, changes: Mapping[str, Any] | None = None) -> zenoh.Config:
    """Return Zenoh's configuration from a profile.

    Args:
        profile: A name in `configs/bus`, or a file: TOML, or Zenoh's own JSON5 when it ends in `.json5` or `.json`.
            `:FOLDER` behind it is the folder of the keys, for a profile with keys.
        changes: Further settings of the command line: `{"listen/endpoints": ["tcp/127.0.0.1:7447"]}`.
    Raises:
        ConfigError: There is no such profile, its keys are missing, or Zenoh does not accept it.
    """
    return _configured(Profile.find(profile), changes or {})


def _configured(profile: Profile, changes: Mapping[str, Any]) -> zenoh.Config:
    """Return Zenoh's configuration from a profile that has been found."""
    path = profile.path
    try:
        if path.suffix in (".json5", ".json"):
            config = zenoh.Config.from_file(path)
        else:
            config = zenoh.Config.from_json5(json.dumps(profile.for_zenoh()))
        for key, value in changes.items():
            config.insert_json5(key, json.dumps(value))
        return config
    except zenoh.ZError as err:
        raise ConfigError(f"{path} is not a configuration of Zenoh: {reason(err)}") from err


@cache
def _warn_once(text: str) -> None:
    log.warning("%s", text)


class ZenohBus(Bus):
    """One participant: a session, and one thread for its handlers.

    Samples, tokens and replies are handled in the order of arrival; queries in the order of arrival of each client,
    and the clients take turns.

    A handler must be quick, since it blocks the others, and must not query what the same bus serves.
    """

    def __init__(
        self, config: zenoh.Config, permit: Permit | None = None, registration: Registration | None = None
    ) -> None:
        """Open a session.

        Args:
            config: Zenoh's configuration.
            permit: What the router allows this program; the rest is refused here, since the router denies silently.
            registration: The registration of this session on this machine; it is closed with the session.
        Raises:
            BusUnavailable: Zenoh cannot open one, for example because an address to listen on is taken.
        """
        threads.set_up()
        try:
            self._session = zenoh.open(config)
        except zenoh.ZError as err:
            raise BusUnavailable(f"the bus cannot be opened: {reason(err)}") from err
        self._identity = str(self._session.zid()).encode()  # carried by each query: clients take turns by it
        self._is_closed = False
        self._permit = permit
        self._registration = registration
        self._scouting: Scouting | None = None
        self._declared: set[Declared] = set()  # Zenoh withdraws a declaration without a reference
        self._opened_at = time.monotonic()
        self._met_at = self._opened_at + (MEETING_TIME if self._has_met_elders() else LATE_MEETING_TIME)
        self._handlers = HandlerThread()
        self._timers = Timers()
        self._links = LinkWatch(self._session.info, self._timers)
        atexit.register(self.close)  # an open session keeps the interpreter from ending

    @classmethod
    def open(cls, profile: str | None = None) -> Self:
        """Open a session with a profile.

        Args:
            profile: A name in `configs/bus`, or a file; `:FOLDER` behind it for a profile with keys, `:NAME` for
                another bus on this machine. None for the default of `--bus`.
        Raises:
            ConfigError: There is no such profile, its keys are missing, or Zenoh does not accept it.
            BusUnavailable: Zenoh cannot open a session, or the router does not admit this certificate.
        """
        found = Profile.find(profile or default_bus())
        if found.local is not None:
            return cls._open_here(found, found.local)
        if found.warning:
            _warn_once(found.warning)
        config = _configured(found, {})
        permit = Permit.of(found)
        try:
            bus = cls(config, permit)
        except BusUnavailable as err:
            dialled = json.loads(config.get_json("connect/endpoints"))
            if permit is None and not dialled:
                raise
            if permit is None:
                raise BusUnavailable(f"{err}; is there a router? acromovi router starts one") from err
            why = found.why_not_let_in(dialled)
            raise BusUnavailable(f"the bus cannot be opened: {why}") from err
        if permit is not None and not bus._is_admitted():
            bus.close()
            raise BusUnavailable(
                f"the router does not know {permit.common_name}, and denies it everything; add this name to the "
                f"file {ADMITTED} in the router's folder of keys, and start the router again"
            )
        return bus

    @classmethod
    def _open_here(cls, profile: Profile, local: LocalBus) -> Self:
        """Open a session on a bus of this machine."""
        for tries_left in reversed(range(MOST_TRIES)):
            registration = Registration(local)
            try:
                config = _configured(profile, registration.configuration)
                bus = cls(config, registration=registration)
            except BusUnavailable:
                registration.close()
                if not tries_left:
                    raise
            except BaseException:
                registration.close()
                raise
            else:
                bus._look_for_plain_programs(local)
                return bus
        raise AssertionError("the last try returns or raises")

    @property
    def own_name(self) -> str | None:
        """The only name that this program may use."""
        return None if self._permit is None else self._permit.own_name

    @property
    def has_met_all(self) -> bool:
        """Whether this session is connected to all that were registered before, or has waited long enough."""
        late = time.monotonic() > self._opened_at + LATE_MEETING_TIME
        return self._is_closed or late or self._has_met_elders()

    def check_may_query(self, key_expr: str) -> None:
        """Check whether this program may send a query."""
        self._require("query", key_expr)

    def publisher(self, key: str, type_name: str) -> Publisher:
        """Declare a stream."""
        plain_key(key)
        encoder = MessageEncoder(type_name)
        self._require("put", key)
        with self._usable():
            handle = self._session.declare_publisher(
                key, encoding=encoder.encoding, congestion_control=zenoh.CongestionControl.DROP
            )
        return _ZenohPublisher(self._declared, handle, encoder)

    def put(self, key: str, message: object, attachment: bytes = b"") -> None:
        """Publish one message once; dropped under congestion."""
        self._put(key, message, attachment, zenoh.CongestionControl.DROP)

    def send(self, key: str, message: object, attachment: bytes = b"") -> None:
        """Publish one message; wait while the way is congested."""
        self._put(key, message, attachment, zenoh.CongestionControl.BLOCK)

    def subscribe(self, key_expr: str, on_sample: Callable[[Sample], None], *, urgent: bool = False) -> Subscription:
        """Subscribe to matching keys."""

        declare = partial(self._session.declare_subscriber, key_expression(key_expr))
        self._require("declare_subscriber", key_expr)
        return self._listen(key_expr, partial(_hear, on_sample), declare, urgent, self._handlers.post_sample)

    def subscribe_latest(self, key: str, on_sample: Callable[[Sample], None], period: float) -> Subscription:
        """Subscribe to the latest sample on a key."""
        check_handler(on_sample)
        self._require("declare_subscriber", plain_key(key))
        with self._usable():
            subscriber = self._session.declare_subscriber(key, zenoh.handlers.RingChannel(1))
            return LatestListening(self._declared, subscriber, guarded(key, partial(_hear, on_sample)), period)

    def serve(self, key: str, answer: Answerer, *, urgent: bool = False) -> Subscription:
        """Answer queries on a key."""
        check_handler(answer)

        def respond(query: zenoh.Query) -> None:
            with query:
                reply = answered(key, answer, query.payload.to_bytes() if query.payload else b"")
                if reply.is_error:
                    query.reply_err(reply.payload, encoding=JSON)
                else:
                    query.reply(key, reply.payload, encoding=JSON)

        declare = partial(self._session.declare_queryable, plain_key(key))
        self._require("declare_queryable", key)
        return self._listen(key, respond, declare, urgent, self._handlers.post_query)

    def converse(self, key: str, handler: Talker, *, urgent: bool = False) -> Subscription:
        """Answer queries on a key with any number of replies."""
        check_handler(handler)
        declare = partial(self._session.declare_queryable, plain_key(key))
        self._require("declare_queryable", key)
        with self._usable():
            listening = ConversationListening(self._declared, key, handler, urgent)
            return self._declare(listening, declare, urgent, self._handlers.post_query)

    def ask(
        self,
        key_expr: str,
        arguments: Mapping[str, Any] | None,
        on_reply: Callable[[Answer], None],
        on_end: Callable[[BusError | None], None],
        timeout: float = QUERY_TIMEOUT,
        *,
        urgent: bool = False,
    ) -> Subscription:
        """Query every program that serves a matching key, and pass on every reply as it comes."""
        replies = Replies(key_expr, on_reply, on_end, timeout)
        get = partial(
            self._session.get,
            key_expression(key_expr),
            target=zenoh.QueryTarget.ALL,
            consolidation=zenoh.ConsolidationMode.NONE,
            payload=encode_json(arguments or {}),
            encoding=JSON,
            attachment=self._identity,
        )
        self._require("query", key_expr)
        with self._usable():
            query = ZenohQuery(
                self._declared, get, self._handlers, self._timers, replies, self._met_at, self._has_met_elders, urgent
            )
            get(**query.options())
        return query

    def declare_alive(self, key: str) -> Subscription:
        """Declare a token until this session ends."""
        plain_key(key)
        self._require("liveliness_token", key)
        with self._usable():
            return Declared(self._declared, self._session.liveliness().declare_token(key))

    def watch_alive(self, key_expr: str, on_change: Callable[[str, bool], None]) -> Subscription:
        """Watch tokens that exist, appear and disappear."""

        def hear(sample: zenoh.Sample) -> None:
            on_change(str(sample.key_expr), sample.kind == zenoh.SampleKind.PUT)

        key = key_expression(key_expr)
        self._require("declare_liveliness_subscriber", key_expr)
        with self._usable():
            declare = self._session.liveliness().declare_subscriber
        return self._listen(key_expr, hear, partial(declare, key, history=True))

    def close(self) -> None:
        """Leave the bus."""
        if not self._is_closed:
            self._is_closed = True
            atexit.unregister(self.close)
            if self._registration is not None:
                self._registration.close()  # first, so that a new session does not connect to this one
            if self._scouting is not None:
                self._scouting.close()
            self._links.close()
            self._timers.close()
            self._handlers.stop()
            try:
                self._session.close()  # type: ignore[no-untyped-call]  # Zenoh's stub says no return type
            except zenoh.ZError as err:  # it is closed, but a connection to a frozen program was still being opened
                log.warning("the bus was closed late: %s", reason(err))
            for held in [held for held in self._declared if isinstance(held, LatestListening)]:
                held.close()

    def deliver(self, sample: Sample) -> None:
        """Publish bytes as they are."""
        self._put_bytes(sample.key, sample.payload, sample.encoding, sample.attachment, zenoh.CongestionControl.DROP)

    def _put(self, key: str, message: object, attachment: bytes, congestion: zenoh.CongestionControl) -> None:
        encoder = MessageEncoder.of(message)
        self._put_bytes(key, encoder.encode(message), encoder.encoding, attachment, congestion)

    def _put_bytes(
        self, key: str, payload: bytes, encoding: str, attachment: bytes, congestion: zenoh.CongestionControl
    ) -> None:
        plain_key(key)
        self._require("put", key)
        with self._usable():
            self._session.put(
                key, payload, encoding=encoding, congestion_control=congestion, attachment=attachment or None
            )

    def _listen(
        self,
        key_expr: str,
        handler: Callable[[Any], None],
        declare: Callable[[Any], Undeclarable],
        urgent: bool = False,
        post: Callable[[Listening, Any], None] | None = None,
    ) -> Subscription:
        """Declare a subscriber or queryable whose handler runs on this bus's thread, or at once if it is urgent."""
        with self._usable():
            listening = Listening(self._declared, guarded(key_expr, handler), urgent)
            return self._declare(listening, declare, urgent, post or self._handlers.post)

    def _declare(
        self,
        listening: Listening,
        declare: Callable[[Any], Undeclarable],
        urgent: bool,
        post: Callable[[Listening, Any], None],
    ) -> Subscription:
        """Declare a subscriber or queryable on the session."""

        def hand_on(item: object) -> None:
            threads.keep()
            post(listening, item)

        # Called on Zenoh's own thread; by default there would be a thread for every declaration.
        handler = zenoh.handlers.Callback(listening.hear if urgent else hand_on, indirect=False)
        listening.handle = declare(handler)
        return listening

    def _has_met_elders(self) -> bool:
        """Return whether this session is connected to all that were registered on this machine before."""
        return self._registration is None or len(self._session.info.peers_zid()) >= len(self._registration.elders)

    def _look_for_plain_programs(self, local: LocalBus) -> None:
        """Let other Zenoh programs of this machine find this session."""
        if self._registration is None:
            return
        try:
            scouting = Scouting(local.scouting_address, str(self._session.zid()), self._registration.endpoint)
        except OSError as err:
            log.warning("programs with Zenoh's own configuration will not find this one: %s", err.strerror)
            return
        self._scouting = scouting

        def on_transport(event: zenoh.TransportEvent) -> None:
            if event.kind == zenoh.SampleKind.DELETE and not self._is_closed:
                scouting.hurry()

        handler = zenoh.handlers.Callback(on_transport, indirect=False)
        self._transports = self._session.info.declare_transport_events_listener(handler)

    def _is_admitted(self) -> bool:
        """Return whether a router answers, which it does to admitted programs only."""
        routers = self._session.info.routers_zid()
        asked = [self._session.get(f"@/{router}/router", timeout=QUERY_TIMEOUT) for router in routers]
        return any(reply.ok for replies in asked for reply in replies)

    def _require(self, message: str, key: str) -> None:
        """Raise NotAllowed for what the router would drop silently."""
        if self._permit is not None:
            self._permit.require(message, key)

    @contextlib.contextmanager
    def _usable(self) -> Iterator[None]:
        """Raise on a closed bus, and translate Zenoh's errors."""
        if self._is_closed:
            raise BusUnavailable("this bus is closed")
        try:
            yield
        except zenoh.ZError as err:
            raise BusUnavailable(f"the bus failed: {reason(err)}") from err


def _hear(on_sample: Callable[[Sample], None], sample: zenoh.Sample) -> None:
    """Pass on a sample, unless it is a deletion."""
    if sample.kind == zenoh.SampleKind.PUT:
        attachment = sample.attachment
        on_sample(
            Sample(
                key=str(sample.key_expr),
                payload=sample.payload.to_bytes(),
                encoding=str(sample.encoding),
                attachment=attachment.to_bytes() if attachment else b"",
            )
        )


class _ZenohPublisher(Declared, Publisher):
    """A key and a type on a Zenoh session."""

    def __init__(self, declared: set[Declared], handle: zenoh.Publisher, encoder: MessageEncoder) -> None:
        super().__init__(declared, handle)
        self._publisher = handle
        self._encoder = encoder
        self._session_declared = declared
        self._watching: list[Declared] = []

    @property
    def has_listeners(self) -> bool:
        if self.handle is None:
            return False
        try:
            status = self._publisher.matching_status  # an object that is true in every case, and holds the answer
            return bool(status.matching)  # type: ignore[attr-defined]  # Zenoh's stub says that the status is a bool
        except zenoh.ZError:  # the bus has been closed
            return False

    def watch_listeners(self, on_change: Callable[[bool], None]) -> None:
        call = guarded(str(self._publisher.key_expr), on_change)

        def hear(status: zenoh.MatchingStatus) -> None:
            threads.keep()
            call(status.matching)

        try:
            listener = self._publisher.declare_matching_listener(zenoh.handlers.Callback(hear, indirect=False))
        except zenoh.ZError as err:
            raise BusUnavailable(f"listeners cannot be watched: {reason(err)}") from err
        self._watching.append(Declared(self._session_declared, listener))

    def close(self) -> None:
        """Withdraw it, and end the calls about its listeners."""
        while self._watching:
            self._watching.pop().close()
        super().close()

    def put(self, message: object, attachment: bytes = b"") -> None:
        payload = self._encoder.encode(message)
        try:
            self._publisher.put(payload, attachment=attachment or None)
        except zenoh.ZError as err:
            raise BusUnavailable(f"this message cannot be published: {reason(err)}") from err

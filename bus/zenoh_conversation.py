"""Conversations on a Zenoh session: one query, and several replies until the responder ends it or has gone."""

import contextlib
import threading
import time
from collections.abc import Callable
from functools import partial
from typing import Any

import zenoh

from bus.bus import JSON, Conversation
from bus.declared import Declared, Listening
from bus.errors import BusUnavailable
from bus.exchange import RawReply, Replies, Talker, reason, refusal, refusing_errors
from bus.handler_thread import HandlerThread
from bus.payload import decode_json, encode_json
from bus.timers import Timers

ASK_AGAIN_AFTER = 0.02  # s
ZENOH_TIMEOUT = b"Timeout"  # Zenoh's own error reply when a program has not answered


class _TimedOut:
    """Zenoh's own report that a program has not answered in time."""


_TIMED_OUT = _TimedOut()


def _read_reply(reply: zenoh.Reply) -> RawReply | None:
    """Return an encoded reply, or None for `_TimedOut`."""
    if reply.ok is not None:
        return RawReply(False, str(reply.ok.key_expr), reply.ok.payload.to_bytes())
    if reply.err is None:  # neither: Zenoh makes no such reply
        return RawReply(True, "", b"an empty reply")
    payload = reply.err.payload.to_bytes()
    if payload == ZENOH_TIMEOUT and str(reply.err.encoding) != JSON:
        return None
    return RawReply(True, "", payload)


class _ZenohConversation(Conversation):
    """The responder's end. Zenoh ends the query when this is closed or deleted, or its process dies."""

    def __init__(self, key: str, query: zenoh.Query) -> None:
        self._key = key
        self._query: zenoh.Query | None = query
        self._lock = threading.Lock()  # a reply and the end may come from different threads

    def reply(self, value: dict[str, Any]) -> None:
        """Send one JSON object."""
        self._send(lambda query, payload: query.reply(self._key, payload, encoding=JSON), encode_json(value))

    def refuse(self, why: str) -> None:
        """Send an error reply, and end it."""
        self._send(lambda query, payload: query.reply_err(payload, encoding=JSON), refusal(why))
        self.close()

    def close(self) -> None:
        """End it; closing it twice has no effect."""
        with self._lock:
            query, self._query = self._query, None
            if query is not None:
                query.drop()  # type: ignore[no-untyped-call]  # Zenoh's stub says no return type

    def _send(self, send: Callable[[zenoh.Query, bytes], object], payload: bytes) -> None:
        with self._lock:
            if self._query is None:
                raise BusUnavailable("this conversation has ended")
            try:
                send(self._query, payload)
            except zenoh.ZError as err:
                raise BusUnavailable(f"this reply cannot be sent: {reason(err)}") from err


class ConversationListening(Listening):
    """A queryable whose handler gets each query as a conversation."""

    def __init__(self, declared: set[Declared], key: str, handler: Talker, is_urgent: bool) -> None:
        super().__init__(declared, handler, is_urgent)
        self._key = key
        self._talker = handler

    def hear(self, item: zenoh.Query) -> None:
        """Begin a conversation, unless this was closed while the query waited."""
        if self._prepare():
            conversation = _ZenohConversation(self._key, item)
            with refusing_errors(self._key, conversation):
                payload = item.payload.to_bytes() if item.payload else b""
                self._talker(decode_json(payload, check_values=False), conversation)


class ZenohQuery(Listening):
    """The initiator's end: open until the replies have ended.

    A session that has just been opened may not be connected to the program that serves the key. So a query that gets no
    reply is sent again until `met_at`; one to all programs that was sent before the session had met all is sent once
    more when it has, or at that time.
    """

    def __init__(
        self,
        declared: set[Declared],
        get: Callable[..., object],
        handlers: HandlerThread,
        timers: Timers,
        replies: Replies,
        met_at: float,
        has_met: Callable[[], bool],
        urgent: bool,
    ) -> None:
        super().__init__(declared, self._take)
        self._get = get
        self._handlers = handlers
        self._timers = timers
        self._replies = replies
        self._deadline = time.monotonic() + replies.timeout
        self._met_at = met_at
        self._has_met = has_met
        self._is_partial = "*" in replies.key_expr and time.monotonic() < met_at and not has_met()
        self._hand_on: Callable[[object], None] = self.hear if urgent else partial(handlers.post, self)
        self._cancellation = zenoh.CancellationToken()

    def options(self) -> dict[str, Any]:
        """Return arguments for `get`: Zenoh's own thread passes the replies and then, in every case, the end."""
        handler: zenoh.handlers.Callback[zenoh.Reply] = zenoh.handlers.Callback(
            lambda reply: self._hand_on(_read_reply(reply) or _TIMED_OUT),
            lambda: self._hand_on(None),
            indirect=False,
        )
        remaining = max(self._deadline - time.monotonic(), 0.001)
        return {"handler": handler, "timeout": remaining, "cancellation_token": self._cancellation}

    def close(self) -> None:
        """Pass on no further replies."""
        was_open = self._is_open
        super().close()
        if was_open:  # cancelling waits for a callback that runs, so it must not happen inside one
            self._handlers.post(Listening(set(), lambda token: token.cancel()), self._cancellation)

    def _take(self, item: RawReply | _TimedOut | None) -> None:
        match item:
            case RawReply():
                self._replies.hear(item)
            case _TimedOut():
                self._replies.time_out()
            case None if self._is_partial and time.monotonic() < self._deadline:
                self._timers.call(ASK_AGAIN_AFTER, self._await_all)
            case None if self._replies.is_silent and time.monotonic() < min(self._met_at, self._deadline):
                self._timers.call(ASK_AGAIN_AFTER, self._send_again)
            case None:
                super().close()
                self._replies.end()

    def _await_all(self) -> None:
        """Send the query once more when the session has met all, or has waited long enough for them."""
        if not self._is_open:
            return
        if self._has_met() or time.monotonic() > self._met_at:
            self._is_partial = False
            self._replies.begin_again()
            # After a moment in which those that are met tell what they serve.
            self._timers.call(ASK_AGAIN_AFTER, self._send_again)
        elif time.monotonic() < self._deadline:
            self._timers.call(ASK_AGAIN_AFTER, self._await_all)
        else:
            self._hand_on(None)

    def _send_again(self) -> None:
        if not self._is_open:
            return
        if time.monotonic() > self._deadline:
            self._hand_on(None)
            return
        with contextlib.suppress(zenoh.ZError):  # the session has been closed meanwhile
            self._get(**self.options())

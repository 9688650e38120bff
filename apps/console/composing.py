"""Messages that are composed in a page: what is entered becomes a draft."""

import json
from collections.abc import Mapping
from math import isfinite
from typing import Any

from agents.platform import AgentName, NameNotValid, Performative
from agents.platform.conversations.any_message import MessageDraft
from configs.suggestion import hint

PERFORMATIVES = [str(each) for each in Performative]


class DraftNotValid(ValueError):
    """A message cannot be sent as it was entered; tells what is expected."""


def draft_of(entered: Mapping[str, str]) -> MessageDraft:
    """Return the draft of a message.

    Args:
        entered: Text by field: performative, receivers (with commas or blanks between), content (JSON), reply_by (s),
            and protocol, conversation, language, ontology, reply_with, in_reply_to.
    Raises:
        DraftNotValid: A field cannot be read.
    """
    performative = entered.get("performative", "")
    if performative not in PERFORMATIVES:
        raise DraftNotValid(f"there is no performative {performative!r}{hint(performative, PERFORMATIVES)}")
    try:
        receivers = [AgentName.parse(text) for text in entered.get("receivers", "").replace(",", " ").split()]
    except NameNotValid as err:
        raise DraftNotValid(str(err)) from err
    if not receivers:
        raise DraftNotValid("a message needs a receiver, such as base@happy")
    texts = ("protocol", "conversation", "language", "ontology", "reply_with", "in_reply_to")
    return MessageDraft(
        performative=Performative(performative),
        receivers=list(dict.fromkeys(receivers)),
        content=_content(entered.get("content", "")),
        reply_by=_seconds(entered.get("reply_by", "")),
        **{name: entered.get(name, "").strip() for name in texts},
    )


def _content(text: str) -> Any:
    if not text.strip():
        return None
    try:
        return json.loads(text)
    except (ValueError, RecursionError) as err:
        raise DraftNotValid(f'the content is not JSON ({err}); a text is written "hello"') from err


def _seconds(text: str) -> float | None:
    if not text.strip():
        return None
    try:
        seconds = float(text)
    except ValueError as err:
        raise DraftNotValid(f"reply-by is a number of seconds from now on, not {text!r}") from err
    if not (isfinite(seconds) and seconds > 0.0):
        raise DraftNotValid(f"reply-by is more than 0 s, not {text}")
    return seconds

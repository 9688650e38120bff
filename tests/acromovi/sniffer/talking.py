"""Messages for sniffers to hear."""

from typing import Any

from agents.platform import AclMessage, AgentName, Performative
from agents.sniffer.captured import CapturedMessage

NOON = 1_767_265_200.0  # s since 1970


def said(
    after: float,
    performative: str,
    sender: str,
    *receivers: str,
    content: Any = None,
    conversation: str = "",
    container: str = "happy",
) -> CapturedMessage:
    """One message, said so many seconds after noon."""
    message = AclMessage(
        performative=Performative(performative),
        sender=AgentName.parse(sender),
        receivers=tuple(map(AgentName.parse, receivers)),
        content=content,
        conversation_id=conversation,
    )
    return CapturedMessage(NOON + after, container, message)


APP, BASE, ARM = "app-1@lab", "base@happy", "arm@max"
MOVE = {"action": "move", "arguments": {"distance": 1.0}}
A_TALK = [
    said(0.0, "request", APP, BASE, content=MOVE, conversation="c0ffee11"),
    said(0.001, "agree", BASE, APP, conversation="c0ffee11"),
    said(0.5, "inform", BASE, APP, ARM, content="<b>&\t moving"),
    said(0.6, "inform", BASE, BASE, content="note"),
    said(1.0, "failure", BASE, APP, content={"why": "the wheels are stalled"}, conversation="c0ffee11"),
    said(1.1, "request", APP, ARM, content=MOVE, conversation="beef"),
]

"""`acromovi send`: send any ACL message, and print the replies, as JADE's dummy agent does."""

import argparse
import asyncio
import json
import sys
from collections.abc import Mapping, Sequence
from contextlib import aclosing
from importlib import import_module
from typing import TYPE_CHECKING, Any

from acromovi.options import add_bus, argument, seconds
from acromovi.subcommand import Subcommand

if TYPE_CHECKING:
    from agents.platform import Agent, AgentName
    from agents.platform.acl import AclMessage

PATIENCE = 10.0  # s
EPILOG = """\
examples:
  acromovi send request base@happy --action move distance=0.5
  acromovi send query-ref laser@happy --action nearest
  acromovi send inform follow@happy --content '{"speed": 0.3}'
  acromovi send cfp base@happy base@doc --action go_to x=1 y=0 --reply-by 3
  acromovi send inform follow@happy --content '"hello"' --protocol my-talk --conversation talk-1 --wait 5

--action makes the content that the agents of Acromovi read: {"action": NAME, "arguments": {...}}. A
performative that begins a conversation (request, request-when, query-if, query-ref, subscribe, cfp, propose, proxy) is
followed by the replies until its end; any other message goes to the mailboxes of its receivers, and replies are printed
for --wait seconds. Each reply is one line: sender, performative and content; with --json the message as JSON.

Exit codes: 0 sent, and each conversation ended with inform or a proposal, 1 refused, failed, not understood, no reply
in time, or no such agent (the reason is on stderr), 2 wrong usage, 130 stopped by Ctrl-C.
"""


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("performative", metavar="PERFORMATIVE", help="type of the message, such as request or inform")
    parser.add_argument("receivers", metavar="RECEIVER", nargs="+", help="agents, such as base@happy")
    parser.add_argument(
        "--action",
        metavar=("NAME", "KEY=VALUE"),
        nargs="+",
        help="set the content to an action with its arguments; a value is JSON, or text where it is not JSON",
    )
    parser.add_argument("--content", type=_json, metavar="JSON", help="set the content")
    parser.add_argument("--protocol", default="", metavar="NAME", help="set the protocol [that of the performative]")
    parser.add_argument("--conversation", default="", metavar="ID", help="set the id of the conversation [a new one]")
    parser.add_argument("--ontology", default="", metavar="NAME", help="set the ontology")
    parser.add_argument("--language", default="", metavar="NAME", help="set the language")
    parser.add_argument("--reply-with", default="", metavar="LABEL", help="set the label of the reply")
    parser.add_argument("--in-reply-to", default="", metavar="LABEL", help="set the label that this replies to")
    parser.add_argument("--reply-by", type=seconds, metavar="S", help="set the time of replies, from now on [none]")
    parser.add_argument("--wait", type=seconds, metavar="S", help="wait for replies [10 s; 0 if it needs none]")
    parser.add_argument("--json", action="store_true", help="print each reply as one line of JSON")
    add_bus(parser)


def _json(text: str) -> Any:
    """A JSON value."""
    try:
        return json.loads(text)
    except ValueError as err:
        raise argparse.ArgumentTypeError(f"{text!r} is not JSON ({err}); a text is written '\"hello\"'") from err


def _run(arguments: argparse.Namespace) -> int:
    """Send one message and print the replies.

    All modules are loaded before the conversation begins: a pause of its heartbeat would stop a motion.
    """
    from acromovi.known_agents import KnownAgents
    from agents.platform.acl import Performative
    from agents.platform.names import AgentName
    from bus.session import ZenohBus
    from configs.suggestion import hint

    for module in ("agents.platform.conversations.any_message", "agents.sniffer.captured"):
        import_module(module)
    names = [str(each) for each in Performative]
    if arguments.performative not in names:
        wrong = f"there is no performative {arguments.performative!r}{hint(arguments.performative, names)}"
        print(f"acromovi send: {wrong}; choose one of {', '.join(names)}", file=sys.stderr)
        return 2
    receivers = [AgentName.parse(each) for each in arguments.receivers]
    content = arguments.content
    if arguments.action is not None:
        if content is not None:
            print("acromovi send: give --action or --content, not both", file=sys.stderr)
            return 2
        name, *given = arguments.action
        try:
            content = {"action": name, "arguments": dict(map(argument, given))}
        except argparse.ArgumentTypeError as err:
            print(f"acromovi send: --action {name}: {err}", file=sys.stderr)
            return 2
    with ZenohBus.open(arguments.bus) as bus:
        with KnownAgents(bus) as known:
            for each in receivers:
                known.expect(each)
        return asyncio.run(_send(bus, arguments, receivers, content))


async def _send(bus: Any, arguments: argparse.Namespace, receivers: Sequence["AgentName"], content: Any) -> int:
    from acromovi.ask import asker
    from agents.platform.acl import Performative
    from agents.platform.conversations.any_message import MessageDraft

    names = ("protocol", "conversation", "language", "ontology", "reply_with", "in_reply_to", "reply_by")
    draft = MessageDraft(
        performative=Performative(arguments.performative),
        receivers=receivers,
        content=content,
        **{name: getattr(arguments, name) for name in names},
    )
    begins = draft.begins_conversation
    wait = PATIENCE if begins and arguments.wait is None else arguments.wait or 0.0
    async with asker(bus, receivers[0]) as agent:
        message = draft.message(agent)
        if begins:
            talks = [_converse(agent, message, each, wait, arguments.json) for each in receivers]
            return 0 if all(await asyncio.gather(*talks)) else 1
        agent.send(message)
        return await _print_mailbox(agent, wait, arguments.json)


async def _converse(agent: "Agent", message: "AclMessage", receiver: "AgentName", wait: float, as_json: bool) -> bool:
    """Begin a conversation and print the replies; return whether the last one is a success."""
    from agents.platform.acl import Performative
    from agents.platform.conversations.any_message import ENDS_WELL, converse
    from agents.platform.errors import in_words
    from bus.errors import BusError

    last = ""
    try:
        async with aclosing(converse(agent, message, receiver, wait)) as replies:
            async for reply in replies:
                last = str(reply.get("performative", ""))
                _show(reply, as_json)
    except (BusError, TimeoutError) as err:
        if last != Performative.PROPOSE:  # a proposal that nobody accepts is the end here
            print(f"acromovi send: {receiver}: {in_words(err) or 'no reply in time'}", file=sys.stderr)
            return False
    return last in ENDS_WELL


async def _print_mailbox(agent: "Agent", wait: float, as_json: bool) -> int:
    """Print what comes for a while; return the exit code."""
    count = 0
    try:
        async with asyncio.timeout(wait):
            while wait:
                _show((await agent.receive()).to_dict(), as_json)
                count += 1
    except TimeoutError:
        pass  # the usual end
    if wait and not count:
        print(f"acromovi send: no reply within {wait:g} s", file=sys.stderr)
        return 1
    return 0


def _show(message: Mapping[str, Any], as_json: bool) -> None:
    from agents.sniffer.captured import brief, shortened

    if as_json:
        print(json.dumps(message, ensure_ascii=False), flush=True)
        return
    sender, performative = (shortened(str(message.get(name, "?")), 80) for name in ("sender", "performative"))
    print(f"{sender}  {performative}  {brief(message.get('content'), 1000)}".rstrip(), flush=True)


COMMAND = Subcommand(EPILOG, _add_arguments, _run)

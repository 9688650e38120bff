"""A broker: finds agents by what they offer, and has them do something or names them.

It is no service of every team; start it where it is needed:
`acromovi agent start broker@team agents.services.broker:BrokerAgent --in services`.
"""

import asyncio
from typing import Any, ClassVar

from agents.platform.agent import PATIENCE, Agent
from agents.platform.conversations.fipa_brokering import BROKER, RECRUIT
from agents.platform.conversations.outcome import Outcome
from agents.platform.conversations.responder_conversation import attended
from agents.platform.directory import Description, Directory
from agents.platform.names import AgentName
from bus import Refused

SHORTEST, LONGEST = 0.1, 3600.0  # s that a forwarded request may take


class BrokerAgent(Agent):
    """Answers proxies."""

    services: ClassVar[tuple[str, ...]] = ("broker",)

    async def setup(self) -> None:
        """Begin to watch which agents there are."""
        self._directory = Directory(self.bus)
        self.answer_proxies(BROKER, self.ask_agents)
        self.answer_proxies(RECRUIT, self.name_agents)

    async def take_down(self) -> None:
        """Stop watching."""
        self._directory.close()

    async def ask_agents(
        self,
        request: str,
        arguments: dict[str, Any] | None = None,
        service: str = "",
        robot: str = "",
        properties: dict[str, Any] | None = None,
        everyone: bool = False,
        within: float = PATIENCE,
    ) -> dict[str, Any]:
        """Have agents do something, and return their results by name.

        Without `everyone` they are asked one after the other, by name, until one has agreed.

        Args:
            request: The name of what they shall do.
            arguments: Of the request.
            service: What they offer; any if empty.
            robot: Of which robot they are; any if empty.
            properties: Which they have, with their values.
            everyone: Ask all that fit, at the same time.
            within: s for each of them.
        Raises:
            Refused: None of them fits, or none has done it; the reasons are in the message.
        """
        given = _table(arguments, "arguments")
        limit = min(max(within, SHORTEST), LONGEST)
        found = await self._found(request, service, robot, properties)
        outcomes: dict[str, Outcome] = {}

        async def ask(peer: AgentName) -> None:
            outcomes[str(peer)] = await self.request(peer, request, reply_within=limit, **given)

        with attended():  # so that nothing moves for an initiator that is silent
            if everyone:
                await asyncio.gather(*(ask(each.name) for each in found))
            else:
                for each in found:
                    await ask(each.name)
                    if outcomes[str(each.name)].is_done or outcomes[str(each.name)].agreed:
                        break
        results = {name: outcome.result for name, outcome in outcomes.items() if outcome.is_done}
        failures = {name: f"{each.ending}: {each.why}" for name, each in outcomes.items() if not each.is_done}
        if not results:
            reasons = "; ".join(f"{name}: {why}" for name, why in failures.items())
            raise Refused(f"nobody has done {request}: {reasons}")
        return {"results": results, "failures": failures}

    async def name_agents(
        self,
        request: str,
        service: str = "",
        robot: str = "",
        properties: dict[str, Any] | None = None,
        everyone: bool = False,
    ) -> dict[str, Any]:
        """Return the names of agents that can do something: the first by name, or all.

        Raises:
            Refused: None of them fits.
        """
        found = await self._found(request, service, robot, properties)
        return {"agents": [str(each.name) for each in (found if everyone else found[:1])]}

    async def _found(
        self, request: str, service: str, robot: str, properties: dict[str, Any] | None
    ) -> list[Description]:
        """Return the agents that fit, by name."""
        wanted = _table(properties, "properties")
        found = await self._directory.search(service or None, robot or None)
        able = [each for each in found if request in each.requests and each.fits(None, wanted)]
        others = [each for each in able if each.name != self.name]
        if not others:
            raise Refused(f"no agent that fits can be asked for {request}")
        return sorted(others, key=lambda each: str(each.name))


def _table(value: object, name: str) -> dict[str, Any]:
    """Return a JSON object of the initiator.

    Raises:
        Refused: It is of another type.
    """
    if value is None or isinstance(value, dict):
        return value or {}
    raise Refused(f"{name} is a JSON object, not {value!r:.80}")

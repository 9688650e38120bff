"""Agents that propose, wait for a condition, haggle, find each other by a broker, and are cloned.

python examples/protocols.py
"""

import asyncio
from pathlib import Path

from agents import Agent
from agents.platform import AgentName, Container, Kinds
from agents.platform.conversations.fipa_brokering import Wanted
from agents.services.broker import BrokerAgent
from bus import MemoryBus, MemoryNetwork
from bus.aio import query


async def main():
    """Show one protocol after the other."""
    network = MemoryNetwork()
    kinds = Kinds([Path(__file__).parent])  # the folder of carrier.py
    async with Container(MemoryBus(network), "lab") as lab, Container(MemoryBus(network), "hall", kinds=kinds) as hall:
        me = Agent("me@lab")
        doc, max_ = (
            kinds.make("carrier:Carrier", AgentName("carrier", robot), {"price": price})
            for robot, price in (("doc", 40.0), ("max", 60.0))
        )
        for agent in (me, BrokerAgent("broker@team")):
            await lab.start(agent)
        for agent in (doc, max_):
            await hall.start(agent)
        hall.show()

        outcome = await me.propose(doc.name, "pass", width=0.5)
        print(f"propose: {outcome.ending}")
        outcome = await me.propose(doc.name, "pass", width=1.5)
        print(f"propose: {outcome.ending}, {outcome.why}")

        asyncio.get_running_loop().call_later(0.3, setattr, doc, "charge", 1.0)
        outcome = await me.request_when(doc.name, "carry", "is_charged", {"least": 0.9}, what="a box")
        print(f"request-when: {outcome.result}")

        def revise(bids):
            least = min(bid.proposal["price"] for bid in bids)
            return {"what": "a chair", "most": 0.8 * least} if len(bids) > 1 else None

        tender = await me.call_for_proposals(
            [doc.name, max_.name], "carry", choose=lambda bids: bids[0], revise=revise, what="a chair"
        )
        print(f"iterated contract net: {tender.done[doc.name]}, for {tender.bids[0].proposal['price']:.2f}")

        wanted = Wanted(service="carry", robot="max")
        outcome = await me.broker("broker@team", wanted, "carry", what="a lamp")
        print(f"brokering: {outcome.result['results']}")
        outcomes = await me.recruit("broker@team", Wanted(service="carry", everyone=True), "carry", what="a plant")
        print(f"recruiting: {sorted(each.result for each in outcomes.values())}")

        order = {"do": "clone", "name": str(doc.name), "as": "twin@doc"}
        await query(me.bus, hall.called.control_key, order, 10.0)
        print(f"cloning: {(await me.request('twin@doc', 'carry', what='a vase')).result}")


if __name__ == "__main__":
    asyncio.run(main())

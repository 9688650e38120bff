"""An agent that carries things: it decides about proposals, answers conditions and calls, and can be cloned."""

from agents import Agent, request
from agents.platform import answers, proposes
from agents.platform.hooks import considers
from bus import Refused


class Carrier(Agent):
    """Carries things; knows its price, its battery and whom it lets pass."""

    services = ("carry",)

    async def setup(self):
        """Begin with nothing carried."""
        self.carried = 0
        self.charge = 0.5

    def pack(self):
        """Return what a clone begins with."""
        return {"carried": self.carried}

    def unpack(self, state):
        """Begin as the original was."""
        self.carried = state["carried"]

    @considers("pass")
    async def may_pass(self, width: float):
        """Let narrow ones pass."""
        if width > 1.0:
            raise Refused("the corridor is too narrow")
        return True

    @answers("is_charged")
    async def is_charged(self, least: float = 0.9):
        """Return whether the battery is full enough."""
        return self.charge >= least

    @proposes("carry")
    async def price(self, what: str, most: float = 100.0):
        """Propose the price, if it is not more than the initiator pays."""
        if self.properties["price"] > most:
            raise Refused("too cheap")
        return {"price": max(self.properties["price"], 0.9 * most)}

    @request("carry")
    async def carry(self, what: str, most: float = 100.0):
        """Carry something."""
        self.carried += 1
        return f"{self.name} carries {what}, the {self.carried}. thing"

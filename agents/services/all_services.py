"""The services of a team: the agents that `acromovi container --services TEAM` starts."""

from collections.abc import Mapping

from agents.platform import Agent
from agents.services.arbiter import Arbiter
from agents.services.loader import Loader
from agents.services.monitor import Monitor
from agents.services.subscription import SubscriptionService

SERVICES: Mapping[str, type[Agent]] = {
    "monitor": Monitor,
    "subscription": SubscriptionService,
    "arbiter": Arbiter,
    "loader": Loader,
}
"""From the local names of the agents to their kinds; each is made with its name and its properties."""

"""Rules for restarting agents that have failed. No bus, no clock.

The rules are a table from agents to rules; the first name that matches counts, `*` stands for anything:

    {"camera": {"attempts": 2}, "app-*": {"attempts": 0}, "*": {}}
"""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from fnmatch import fnmatchcase
from typing import Any

from agents.platform import AgentName
from configs import build


@dataclass(frozen=True, slots=True)
class _RestartRule:
    """The rule for restarting one kind of agents.

    attempts: consecutive attempts; 0 for none, -1 for any number.
    first, longest: s of the pause before the first attempt, which doubles with each further one, and of the longest.
    healthy_after: s of life after an attempt by which what was before is forgiven. One that fails sooner is flapping,
        and its next attempt is the next in the row.
    """

    attempts: int = 5
    first: float = 0.2
    longest: float = 30.0
    healthy_after: float = 60.0

    def pause(self, attempt: int) -> float:
        """Return the pause before an attempt, s; the first attempt is 1."""
        return float(min(self.longest, self.first * 2.0 ** min(attempt - 1, 60)))


ANY = "*"
DEFAULT = _RestartRule()


@dataclass(slots=True)
class _Attempts:
    """Attempts in a row. at: when the last was made, s; None while it is still to come."""

    attempts: int = 0
    at: float | None = None


class Restarts:
    """The rules by agent, and the attempts for each failed one."""

    def __init__(
        self, tables: Mapping[str, Mapping[str, Any]] | None = None, source: str = "the restart rules"
    ) -> None:
        """Read the rules.

        Args:
            tables: From the local names of agents, or patterns of them, to what differs from the default.
            source: The name of the source, for messages.
        Raises:
            ConfigError: A table is not valid.
        """
        self._rules = {
            pattern: build(_RestartRule, table, f"{source} for {pattern!r}")
            for pattern, table in (tables or {}).items()
        }
        self._rows: dict[AgentName, _Attempts] = {}

    def rules(self) -> dict[str, dict[str, Any]]:
        """Return the rules as JSON."""
        return {pattern: asdict(rule) for pattern, rule in {ANY: DEFAULT, **self._rules}.items()}

    def rule_of(self, agent: AgentName) -> _RestartRule:
        """Return the rule for an agent."""
        return next((rule for pattern, rule in self._rules.items() if fnmatchcase(agent.local, pattern)), DEFAULT)

    def failed(self, agent: AgentName, now: float) -> float | None:
        """Note a failure of an agent; return s until its restart, or None for no restart."""
        rule, row = self.rule_of(agent), self._rows.setdefault(agent, _Attempts())
        if row.at is not None and now - row.at >= rule.healthy_after:
            row.attempts = 0
        row.attempts += 1
        row.at = None
        if rule.attempts < 0 or row.attempts <= rule.attempts:
            return rule.pause(row.attempts)
        del self._rows[agent]  # a restart by hand begins a new series
        return None

    def attempted(self, agent: AgentName, now: float) -> None:
        """Note a restart of an agent."""
        if agent in self._rows:
            self._rows[agent].at = now

    def attempts(self, agent: AgentName) -> int:
        """Return the number of consecutive attempts, with the one under way."""
        row = self._rows.get(agent)
        return row.attempts if row else 0

    def forget(self, agent: AgentName) -> None:
        """Forget an agent that another program has restarted."""
        self._rows.pop(agent, None)

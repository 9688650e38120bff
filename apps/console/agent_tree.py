"""The agents as a tree, and the search in their descriptions (the yellow pages)."""

import json
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from agents.platform import ContainerName
from agents.platform.containers import ContainerReport
from apps.console.agent_watch import WatchedAgent


def tree_of(
    reports: Iterable[ContainerReport],
    silent: Iterable[ContainerName],
    agents: Mapping[str, WatchedAgent],
    search: str = "",
) -> list[dict[str, Any]]:
    """Return sites, their containers and their agents as JSON for the browser, each sorted by name.

    Args:
        reports: Of the containers that answer.
        silent: Containers that do not answer.
        agents: By name.
        search: Words that agents must have (`has_words`). Containers and sites without such an agent are left out.
    """
    words = search.split()
    sites: dict[str, list[dict[str, Any]]] = {}
    for report in reports:
        known = [agents[str(row.name)] for row in report.agents if str(row.name) in agents]
        listed = [each for each in known if each.container == report.container]  # one that moves may be in two reports
        rows = [_agent_row(each) for each in sorted(listed, key=lambda each: each.name) if has_words(each, words)]
        if rows or not words:
            about = f"process {report.process} on {report.host}"
            sites.setdefault(report.container.platform, []).append(
                {"name": report.container.name, "about": about, "answers": True, "agents": rows}
            )
    for name in silent:
        if not words:
            row = {"name": name.name, "about": "does not answer", "answers": False, "agents": []}
            sites.setdefault(name.platform, []).append(row)
    return [
        {"site": site, "containers": sorted(rows, key=lambda row: str(row["name"]))}
        for site, rows in sorted(sites.items())
    ]


def has_words(agent: WatchedAgent, words: Sequence[str]) -> bool:
    """Return whether an agent fits all words of a search.

    A word is a part of its name, container, kind, or the name of a service or of something that it can be asked for;
    or `service=laser`, or a property with its value, `colour=red`; or the beginning of a state, `state=susp`.
    """
    return all(_has(agent, word) for word in words)


def _has(agent: WatchedAgent, word: str) -> bool:
    key, equals, value = word.partition("=")
    described = agent.description
    properties = described.properties if described is not None else {}
    services = described.services if described is not None else ()
    if not equals:
        asked = (*described.requests, *described.answers, *described.subscriptions) if described is not None else ()
        texts = (str(agent.name), agent.container.name, agent.kind, *services, *asked, *properties)
        return any(word.lower() in text.lower() for text in texts)
    if key == "service":
        return value in services
    if key == "state":
        return agent.state.startswith(value)
    return key in properties and value in (properties[key], json.dumps(properties[key], ensure_ascii=False))


def _agent_row(agent: WatchedAgent) -> dict[str, Any]:
    described = agent.description
    return {
        "name": str(agent.name),
        "state": agent.state,
        "services": list(described.services) if described is not None else [],
        "properties": {key: _short(value) for key, value in described.properties.items()} if described else {},
    }


def _short(value: object, longest: int = 60) -> str:
    """Return a property as text that fits a line."""
    text = value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)
    return text if len(text) <= longest else text[: longest - 1] + "…"

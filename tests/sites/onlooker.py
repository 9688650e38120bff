"""Someone at a site who sees what is on the bus: `python -m tests.sites.onlooker ROBOT ...`.

Answers questions from standard input in JSON, a line each: `{"names": true}` and `{"search": ROBOT}` of the directory,
`{"ask": AGENT, "request": NAME}`, and, once it has been told to `{"listen": true}`, `{"count": true}`: for each robot
how many poses have come, and how many of them twice.
"""

import asyncio
import json
import sys
from collections import Counter
from typing import Any

from agents.platform import Agent, AgentName, Container, Directory
from bus import Sample, ZenohBus, keys, messages


def say(**facts: Any) -> None:
    """One line."""
    print(json.dumps(facts), flush=True)


class Poses:
    """The odometry of one robot: every stamp must come once."""

    def __init__(self) -> None:
        self.stamps: Counter[int] = Counter()

    def hear(self, sample: Sample) -> None:
        """Take one."""
        self.stamps[messages.stamp_ns(messages.decode(keys.ODOM.type_name, sample.payload).header)] += 1

    @property
    def doubled(self) -> int:
        """How many came more than once."""
        return sum(count > 1 for count in self.stamps.values())


async def look(robots: list[str]) -> None:
    """Look, and answer, until the input ends."""
    with ZenohBus.open("router") as bus:
        poses = {robot: Poses() for robot in robots}
        with Directory(bus) as directory:
            async with Container(bus, f"onlooker-{robots[0]}") as container:
                asker = Agent(AgentName("onlooker", f"site-{robots[0]}"))
                await container.start(asker)
                say(ready=True)
                while line := await asyncio.to_thread(sys.stdin.readline):
                    question = json.loads(line)
                    if "listen" in question:
                        for robot, heard in poses.items():
                            bus.subscribe(keys.ODOM.key(robot), heard.hear)
                        say(listening=True)
                    else:
                        await answer(question, asker, directory, poses)


async def answer(question: dict[str, Any], asker: Agent, directory: Directory, poses: dict[str, Poses]) -> None:
    """Say what was asked."""
    match question:
        case {"ask": str(agent), "request": str(request)}:
            outcome = await asker.request(agent, request, reply_within=3.0)
            say(ending=str(outcome.ending))
        case {"count": True}:
            say(**{robot: [len(heard.stamps), heard.doubled] for robot, heard in poses.items()})
        case {"names": True}:
            say(names=[str(name) for name in directory.names])
        case {"search": str(robot)}:
            found = await directory.search(robot=robot)
            say(found=[str(description.name) for description in found])


if __name__ == "__main__":
    asyncio.run(look(sys.argv[1:]))

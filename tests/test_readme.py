"""What README and its reference pages tell people to type, run as it stands; only names of robots and ports differ."""

import re
import shlex
import sys
import uuid
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import pytest

from acromovi.__main__ import main
from acromovi.children import EmulatedRobots, emulator, gateway
from agents.platform import Agent, AgentName, request
from bus import ZenohBus, keys
from gateway.elements.adapter import adapter_types
from gateway.elements.all_elements import ELEMENTS
from gateway.streams import STREAMS
from tests.acromovi.agents_alive import living
from tests.live_team import own_bus
from tests.reader import Reader, blocks, links
from tests.waiting import run, wait_until

ROOT = Path(__file__).parents[1]
README, BUS, COMMAND_LINE, GATEWAY, TESTING = (
    (ROOT / name).read_text(encoding="utf-8")
    for name in ("README.md", "docs/bus.md", "docs/command-line.md", "docs/gateway.md", "docs/testing.md")
)
MOST_LINES = 150  # of README
PROGRAMS = {"p2os-emu": "p2os_emu", "p2os-gateway": "gateway", "acromovi": "acromovi"}


@dataclass
class Setting:
    """A robot with its gateway, named as no other test's."""

    name: str
    port: str
    robots: EmulatedRobots

    def personal(self, text: str) -> str:
        """Return a text with this robot's name and port."""
        return re.sub(r"\bpowerbot/", f"{self.name}/", text.replace("/tmp/powerbot", self.port))


@pytest.fixture
def setting(tmp_path: Path) -> Iterator[Setting]:
    name, port = f"readme-{uuid.uuid4().hex[:8]}", str(tmp_path / "port")
    with ExitStack() as stack:
        robots = stack.enter_context(emulator("--robot", f"powerbot:{name}", "--pty", port, "--quiet"))
        stack.enter_context(gateway(port, "--quiet"))
        bus = stack.enter_context(ZenohBus.open())
        heard: list[str] = []
        bus.subscribe(keys.ODOM.key(name), lambda sample: heard.append(sample.key))
        wait_until(lambda: heard, "odometry came")
        yield Setting(name, port, robots)


def blocks_in(page: str, language: str) -> list[str]:
    return [text for each, text in blocks(page) if each == language]


def commands(program: str) -> list[list[str]]:
    """Every command line of a program in README's shell blocks, without comments."""
    lines = [line.partition("#")[0].strip() for block in blocks_in(README, "") for line in block.splitlines()]
    words = [shlex.split(line) for line in lines if line.startswith(".venv/bin/")]
    return [line for line in words if Path(line[0]).name == program]


def test_readme_is_short_and_has_three_pictures() -> None:
    assert len(README.splitlines()) <= MOST_LINES
    assert len(re.findall(r"^!\[", README, re.MULTILINE)) == 3


def test_readme_names_every_page() -> None:
    assert {page.resolve() for page in (ROOT / "docs").glob("*.md")} <= {
        to.resolve() for to in links(ROOT / "README.md")
    }


def test_readme_shows_every_program() -> None:
    assert all(commands(program) for program in PROGRAMS)


def test_emulator_lines_of_readme_start_a_robot(tmp_path: Path) -> None:
    for line in commands("p2os-emu"):
        arguments = [word.replace("/tmp/powerbot", str(tmp_path / "robot")) for word in line[1:]]
        with emulator(*arguments, "--quiet") as robots:
            assert robots.robots[0]["model"] == "powerbot"


def test_looking_lines_of_readme_show_the_robot(setting: Setting) -> None:
    for line in commands("acromovi"):
        if line[1] == "teleop":
            continue  # wants a terminal, and is tested with one
        limit = {"topics": ["--seconds", "1"], "echo": ["--count", "1"]}.get(line[1], [])
        arguments = [setting.personal(word) for word in line[1:]]
        done = run([sys.executable, "-m", "acromovi", *arguments, *limit], cwd=ROOT)
        assert done.returncode == 0, done.stderr
        assert setting.name in done.stdout


def own_program() -> str:
    """Return the program that uses only the bus."""
    (program,) = blocks_in(BUS, "python")
    return program


def test_program_on_the_bus_drives_until_something_is_near(setting: Setting) -> None:
    start = setting.robots.ask("truth", robot=setting.name)
    setting.robots.ask("pose", robot=setting.name, x=13.8, y=6.1, heading=0.0)
    done = run([sys.executable, "-c", setting.personal(own_program())], cwd=ROOT)
    assert done.returncode == 0, done.stderr
    end = setting.robots.ask("truth", robot=setting.name)
    assert end["x"] > 13.9 > start["x"]


def test_program_on_the_bus_ends_with_a_message_when_the_robot_is_not_there(robot: str) -> None:
    program = re.sub(r"\bpowerbot\b", robot, own_program())
    done = run([sys.executable, "-c", program], cwd=ROOT)
    assert done.returncode == 1
    assert done.stderr.startswith(f"no sonar readings of {robot} for 3 s; start its gateway")


def test_tests_on_the_page_about_the_plugin_pass(tmp_path: Path) -> None:
    tests = blocks_in(TESTING, "python")
    (tmp_path / "test_mine.py").write_text("\n".join(tests))
    (tmp_path / "pioneer_driver.py").symlink_to(ROOT / "examples" / "foreign-driver" / "pioneer_driver.py")
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-p", "no:xdist", "test_mine.py"]
    done = run(command, 60.0, cwd=tmp_path)  # a pytest that starts an emulator
    assert f"{len(tests)} passed" in done.stdout, done.stdout + done.stderr


def test_first_program_of_readme_is_the_example_that_is_tried_elsewhere() -> None:
    example = (ROOT / "examples" / "square.py").read_text(encoding="utf-8")
    assert blocks_in(README, "python") == [example.partition('"""\n\n')[2]]


class Base(Agent):
    """A base that need not drive."""

    services: ClassVar[tuple[str, ...]] = ("base", "laser")

    @request("move")
    async def move(self, distance: float) -> float:
        return distance

    @request("read")
    async def read(self) -> float:
        return 0.0


AGENTS = COMMAND_LINE.partition("## Agents")[2].partition("## ")[0]
AGENT_LINES = [f"acromovi {line}" for line in re.findall(r"`acromovi (.*?)`", AGENTS)]
WITH_PROCESSES = ("acromovi container ", "acromovi agent ")


@pytest.fixture
def reader(tmp_path: Path) -> Iterator[Reader]:
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    reader = Reader(own_bus(tmp_path))
    yield reader
    reader.leave()


def test_agent_commands_work_in_their_order(reader: Reader) -> None:
    shown = {
        "container": "the container {} serves; stop with Ctrl-C\n",
        "start": "follow@happy is active in workshop\n",
        "suspend": "follow@happy is suspended in workshop\n",
        "resume": "follow@happy is active in workshop\n",
        "move": "follow@happy is active in attic\n",
        "clone": "twin@happy is active in attic\n",
        "stop": "follow@happy is deleted in attic\n",
    }
    lines = [line.split() for line in AGENT_LINES if line.startswith(WITH_PROCESSES)]
    assert {words[1] if words[1] == "container" else words[2] for words in lines} == shown.keys()
    for words in lines:
        reader.type(" ".join(words))
        reader.see(shown[words[1] if words[1] == "container" else words[2]].format(words[2]))


def test_agents_do_what_the_page_about_commands_asks_them(
    robot: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    lines = [shlex.split(line)[1:] for line in AGENT_LINES if not line.startswith(WITH_PROCESSES)]
    assert {line[0] for line in lines} == {"ps", "directory", "ask", "send", "sniff", "introspect"}
    names = {"base@happy": f"base@{robot}", "sonar@happy": f"base@{robot}", "10": "0.5"}
    with living(robot, Base(AgentName("base", robot))):
        for line in lines:
            assert main([names.get(word, word) for word in line]) == 0
    assert "<svg" in (tmp_path / "talk.svg").read_text()


def test_page_of_the_gateway_lists_every_stream_and_command_of_the_gateway() -> None:
    adapters = [adapter for row in ELEMENTS for adapter in adapter_types(row)]
    served = [
        *STREAMS,
        *(row.topic for adapter in adapters for row in adapter.commands),
        *(topic for adapter in adapters for topic in (*adapter.streams, *adapter.subscriptions)),
        keys.LEASE,
        keys.DESCRIPTION,
    ]
    rows = [line for line in GATEWAY.splitlines() if line.startswith("| `")]
    for topic in served:
        row = next((row for row in rows if f"`{topic.suffix}`" in row), None)
        assert row is not None, f"the page does not list {topic.suffix}"
        short_name = topic.type_name.rpartition("/")[2]
        assert short_name in row or topic.type_name == "application/json"

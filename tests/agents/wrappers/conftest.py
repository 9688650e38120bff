"""Wrapped programs at work, and an agent that asks them; in real time, since they are real."""

import asyncio
import shutil
import socket
import subprocess
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import pytest

from agents.platform import Agent, AgentName, Container, Outcome, Report
from agents.wrappers.wrapped import Wrapped
from agents.wrappers.wrapper_file import WrapperFile
from bus import MemoryBus
from tests.waiting import waiting

NAME = AgentName("it", "happy")


class Bench:
    """A wrapped program, and a console that asks it and hears its results."""

    def __init__(self, container: Container, reports: list[Report]) -> None:
        self.container = container
        self.reports = reports
        self.console = Agent("console@lab")
        self.results: list[dict[str, Any]] = []

    async def ask(self, name: str, **arguments: Any) -> Outcome:
        return await self.console.request(NAME, name, **arguments)

    async def until(self, condition: Callable[[], object]) -> None:
        async with waiting():
            while not condition():
                await asyncio.sleep(0.005)


@asynccontextmanager
async def bench(file: Path) -> AsyncIterator[Bench]:
    reports: list[Report] = []
    async with Container(MemoryBus(), "lab", report=reports.append) as container:
        made = Bench(container, reports)
        await container.start(made.console)

        async def hear(result: dict[str, Any]) -> None:
            made.results.append(result)

        made.console.listen(NAME.results_key, hear, keep=100)
        await container.start(Wrapped(NAME, *WrapperFile.load(str(file))))
        yield made


@pytest.fixture
def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port: int = server.getsockname()[1]
    return port


@pytest.fixture(scope="session")
def filters(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The library of `filters.c`, compiled."""
    compiler = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
    if compiler is None:
        pytest.skip("no C compiler is installed")
    library = tmp_path_factory.mktemp("filters") / "filters.so"
    source = Path(__file__).with_name("filters.c")
    subprocess.run([compiler, "-shared", "-fPIC", "-O2", "-o", library, source], check=True)
    return library

"""A site with keys: an authority, a router that asks for certificates, and profiles for its port."""

import subprocess
import sys
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, datetime, timedelta
from pathlib import Path
from socket import create_server

from acromovi.authority import AUTHORITY, Authority
from bus import ZenohBus
from configs.loader import find

ROOT = Path(__file__).resolve().parents[2]
YEAR = timedelta(days=365)
MEMBERS = ("viewer.vera", "operator.anna", "robot.happy", "robot.grumpy", "admin.root")


class Site:
    """Keys in a folder, and how to reach the router."""

    def __init__(self, folder: Path, host: str = "127.0.0.1") -> None:
        with create_server((host, 0)) as probe:
            self.endpoint = f"tls/{host}:{probe.getsockname()[1]}"
        self.folder = folder
        self.now = datetime.now(UTC)

    def make(self, owner: str, now: datetime | None = None, life: timedelta = YEAR) -> Path:
        """A key that begins to be valid at `now`."""
        role, _, name = owner.partition(".")
        begins = now or self.now
        has_authority = (self.folder / AUTHORITY).exists()
        authority = Authority(self.folder, begins) if has_authority else Authority.begin(self.folder, begins)
        return authority.make(role, name, begins, life)

    def profile(self, owner: str, template: str = "secure") -> str:
        """A copy of a profile with this site's address, and whose keys to use."""
        text = find("bus", template).read_text(encoding="utf-8").replace("tls/127.0.0.1:7447", self.endpoint)
        path = self.folder / f"{template}-{self.endpoint.rpartition(':')[2]}.toml"
        whole = path.with_suffix(f".{uuid.uuid4().hex}")
        whole.write_text(text, encoding="utf-8")
        whole.replace(path)  # another thread of the test may read it meanwhile
        return f"{path}:{self.folder / owner}"

    def open(self, owner: str) -> ZenohBus:
        """Join the bus as one of the owners."""
        return ZenohBus.open(self.profile(owner))

    @contextmanager
    def routed(self) -> Iterator[None]:
        """Run the router, in a process of its own."""
        command = [sys.executable, "-m", "acromovi", "router", "--config", self.profile("router.lab", "secure-router")]
        with subprocess.Popen(command, cwd=ROOT, text=True, stdout=subprocess.PIPE) as process:
            try:
                assert process.stdout is not None
                assert process.stdout.readline() == f"routing on {self.endpoint}; stop with Ctrl-C\n"
                yield
            finally:
                process.kill()

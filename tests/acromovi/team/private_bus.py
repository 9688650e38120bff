"""A bus of a test's own: a team's robots have names that other tests may use as well."""

import socket
from pathlib import Path

from bus import ZenohBus
from configs import find


def private_bus(folder: Path) -> str:
    """A profile of this machine only, whose programs meet nobody else's."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    local = find("bus", "local").read_text()
    assert "[scouting.multicast]\n" in local
    path = folder / "bus.toml"
    path.write_text(local.replace("[scouting.multicast]\n", f'[scouting.multicast]\naddress = "224.0.0.224:{port}"\n'))
    ZenohBus.open(str(path)).close()
    return str(path)

"""Programs that know Zenoh and nothing of ours, on the bus of the test."""

import json

import zenoh

from bus.secure import Profile
from configs.defaults import default_bus


def plain_session() -> zenoh.Session:
    """Open a session with Zenoh's own configuration, but for what keeps it on this machine and on the test's bus."""
    local = Profile.find(default_bus()).local
    assert local is not None
    group, port = local.scouting_address
    settings = {
        "mode": "peer",
        "listen": {"endpoints": ["tcp/127.0.0.1:0"]},
        "scouting": {"multicast": {"interface": "lo", "address": f"{group}:{port}"}, "gossip": {"enabled": False}},
    }
    return zenoh.open(zenoh.Config.from_json5(json.dumps(settings)))

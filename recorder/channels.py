"""What the bus is in a file: channels of keys, the tokens, and which keys may be published again.

The key `happy/odom` is the topic `/happy/odom`. Messages of ROS 2 types are CDR with their definition, JSON objects
have no schema. Tokens are on a channel of their own, descriptions on the key on which programs ask for them.
"""

import struct

from bus import keys
from bus.bus import JSON, Sample
from bus.messages import NS_PER_S

FORMAT = 1
"""Version of what is described here, in the metadata record of a file."""
TOKENS = "tokens"
"""The channel of tokens: `{"key": "happy/alive", "alive": true}`."""
COMMANDING = frozenset({"acl", "cmd_vel", "cmd_vel_stamped", "command", "control", "lease", "send", "query"})
"""Chunks of keys on which programs are told to do something. Nothing recorded is ever published on such a key."""
SLOWEST, FASTEST = 0.01, 100.0
"""Speeds of a playback, in recorded seconds per second."""
_HEADED = struct.Struct("<iI")  # seconds and nanoseconds of a header's stamp, behind the four bytes of the encoding
_LITTLE_ENDIAN = 1


def topic_of_key(key: str) -> str:
    """Return the topic of a key in a file."""
    return f"/{key}"


def key_of_topic(topic: str) -> str:
    """Return the key of a topic of a file."""
    return topic.removeprefix("/")


def is_stream(key: str) -> bool:
    """Return whether samples on a key only tell something, so that they may be published again.

    Descriptions and tokens are no samples on the bus, and a heartbeat would show life where there is none.
    """
    chunks = key.split("/")
    topic = keys.topic_of(key)
    if topic is keys.LEASE_STATE:
        return True
    if COMMANDING.intersection(chunks[1:]) or chunks[-1] in ("description", "heartbeat") or len(chunks) < 2:
        return False
    return topic is None or topic.kind is keys.Kind.STREAM


def published_ns(sample: Sample, default: int, has_header: bool) -> int:
    """Return the stamp of a sample's header in ns since 1970, or the default if it has none."""
    payload = sample.payload
    if not has_header or len(payload) < 12 or sample.encoding == JSON or payload[1] != _LITTLE_ENDIAN:
        return default
    seconds, nanoseconds = _HEADED.unpack_from(payload, 4)
    return seconds * NS_PER_S + nanoseconds if seconds > 0 else default

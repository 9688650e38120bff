"""What fusing costs: ten sources at 100 Hz each, through the bus, to a fuser in a process of its own.

Nine sources want nothing. The tenth wants to move, by turns: it is alive, it is silent, and it repeats a reading that
grows old. So whatever moves in the fused command is its doing, and whoever knows when its last reading was made knows
whether that was still young.
"""

import argparse
import json
import time

from apps.indoor_navigation.component import push_key, query_key
from apps.indoor_navigation.data import MotionCmd
from benchmarks.agents import peer
from benchmarks.figures import Figure
from benchmarks.processes import CpuMeter
from bus import JSON, Publisher, Sample, ZenohBus
from bus.messages import decode_json

ROBOT, KIND = "bench", "apps.indoor_navigation.components.motion_fuser:MotionFuser"
SOURCES, RATE_HZ, SECONDS, SETTLE_S = 10, 100.0, 30.0, 2.0
MAX_AGE_S = 0.2
TURN_S = 0.5  # for which the tenth source is alive, is silent, or repeats itself
MOVER = f"source{SOURCES - 1}"
AT_ONCE = 1e6  # m/s²: what is wanted is seen in the very next fused command


def measure(options: argparse.Namespace) -> list[Figure]:
    """Processor time of the fuser, what it heard, and the old commands that it used; all on one beat, and spread."""
    spread = 1.0 / (RATE_HZ * SOURCES)
    return [*_measured("all on one beat", 0.0), *_measured("spread", spread)]


def _measured(how: str, apart: float) -> list[Figure]:
    """With so many s between one source and the next."""
    names = [f"source{number}" for number in range(SOURCES)]
    fusion = {"acceleration": AT_ONCE, "braking": AT_ONCE, "sources": {name: {"max_age": MAX_AGE_S} for name in names}}
    properties = {"hears": [[name, "MotionCmd"] for name in names], "numbers": {"fusion": fusion}}
    fused: list[MotionCmd] = []

    def hear(sample: Sample) -> None:
        fused.append(MotionCmd.from_json(decode_json(sample.payload)))

    with peer("component", KIND, f"motion_fuser@{ROBOT}", json.dumps(properties)) as pid, ZenohBus.open() as bus:
        bus.subscribe(push_key(ROBOT, "motion_fuser", MotionCmd), hear)
        sources = {name: bus.publisher(push_key(ROBOT, name, MotionCmd), JSON) for name in names}
        _say_all(sources, SETTLE_S, apart)
        fused.clear()
        meter = CpuMeter(pid)
        readings = _say_all(sources, SECONDS, apart)
        share = meter.percent()
        (load,) = bus.query(query_key(ROBOT, "motion_fuser", "load"))
    missed = SOURCES * RATE_HZ - sum(source["rate"] for source in load.value["sources"].values())
    used = sum(_age(one, readings) > MAX_AGE_S for one in fused if one.linear > 0.0)
    moving = sum(one.linear > 0.0 for one in fused)
    return [
        Figure("fuser", f"processor, {SOURCES} sources at {RATE_HZ:g} Hz, {how}", share, 10.0, "%"),
        Figure("fuser", f"commands that it missed in the last second, of 1000, {how}", missed, 100.0, ""),
        Figure("fuser", f"too old, and used, in {len(fused)} fused, {how}", used, 0.0, "", moving),
    ]


def _say_all(sources: dict[str, Publisher], seconds: float, apart: float) -> list[float]:
    """Speak for all sources, each time that they would have a reading; the stamps of those of the one that moves."""
    readings: list[float] = []
    began = time.monotonic()
    for beat in range(int(seconds * RATE_HZ)):
        turn = int(beat / RATE_HZ / TURN_S) % 4
        for number, (name, source) in enumerate(sources.items()):
            time.sleep(max(0.0, began + beat / RATE_HZ + number * apart - time.monotonic()))
            now = time.time()
            if name != MOVER:
                source.put(MotionCmd(now, name, 0.0, 0.0, 0.0).to_json())
                continue
            if turn in (0, 2):  # alive
                readings.append(now)
            if turn != 1:  # silent
                source.put(MotionCmd(readings[-1], name, 0.5, 0.0, 1.0).to_json())
    return readings


def _age(fused: MotionCmd, readings: list[float]) -> float:
    """Of the newest reading that wanted this, when it was fused, s; the other sources' stamps tell the time of that."""
    return fused.stamp - max((stamp for stamp in readings if stamp <= fused.stamp), default=fused.stamp)

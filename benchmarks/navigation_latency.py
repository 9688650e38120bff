"""From a scan or a sonar message to the fused command that knows of it, with all components in processes of their own.

The robot is played: it stands in a room, and sends odometry, sonar and scan in turns, evenly, so that no other reading
is as new as the one that was sent last. The fused command carries the stamp of the newest reading that it follows from.
"""

import argparse
import json
import time
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from typing import Any

import numpy as np

import configs
from apps.indoor_navigation.component import push_key, send_key
from apps.indoor_navigation.data import GoalPoint, MotionCmd
from apps.indoor_navigation.wiring import ComponentSpec, load_wiring
from benchmarks.agents import peer
from benchmarks.figures import Figure, percentile
from bus import Bus, Sample, ZenohBus, keys
from bus.messages import (
    Header,
    LaserScan,
    Odometry,
    Point,
    Pose,
    PoseWithCovariance,
    Range,
    RangeArray,
    TwistWithCovariance,
    decode_json,
    header,
    quaternion,
    twist,
)

ROBOT, MODEL = "bench", "p2dx"
PERIOD_S, SECONDS, SETTLE_S = 0.1, 60.0, 5.0
BEAMS = 361
WALL_M = 3.0
GOAL_M = (2.0, 1.0)
REACH_MS = 20.0


def measure(options: argparse.Namespace) -> list[Figure]:
    """The time from either sensor to the fused command, ms."""
    wiring = load_wiring()
    fused: list[tuple[float, float]] = []  # stamp of the newest reading, and when it came, s since 1970

    def hear(sample: Sample) -> None:
        fused.append((float(decode_json(sample.payload)["stamp"]), time.time()))

    with ExitStack() as stack:
        bus = stack.enter_context(ZenohBus.open())
        robot = _Robot(bus)
        for part in wiring.parts:
            stack.enter_context(peer("component", *_arguments(part)))
        bus.subscribe(push_key(ROBOT, "motion_fuser", MotionCmd), hear, urgent=True)
        _play(robot, SETTLE_S)
        bus.send(send_key(ROBOT, "path_planning", GoalPoint), GoalPoint("bench", *GOAL_M).to_json())  # all are at work
        sent = _play(robot, SECONDS)
    name = f"scan or sonar message to fused command, {len(wiring.parts)} processes"
    late = {sensor: [_latency(at, fused) for at in times] for sensor, times in sent.items()}
    both = [each for times in late.values() for each in times]
    return [
        Figure("navigation_latency", f"{name}, p50", percentile(both, 50), REACH_MS, "ms", len(both)),
        *(
            Figure("navigation_latency", f"{sensor} to fused command, p99", percentile(times, 99), REACH_MS, "ms")
            for sensor, times in late.items()
        ),
        Figure("navigation_latency", f"{name}, p99", percentile(both, 99), REACH_MS, "ms", len(both)),
    ]


def _arguments(part: ComponentSpec) -> tuple[str, str, str]:
    return part.kind, str(part.agent(ROBOT)), json.dumps(part.properties)


def _latency(at: float, fused: list[tuple[float, float]]) -> float:
    """ms from a reading to the first fused command that is as new; endless where none came."""
    return min(((came - at) * 1e3 for stamp, came in fused if stamp >= at - 1e-6), default=float("inf"))


def _play(robot: "_Robot", seconds: float) -> Mapping[str, list[float]]:
    """Let the robot send; when it sent sonar and scans, s since 1970."""
    sent: dict[str, list[float]] = {"sonar": [], "scan": []}
    steps: tuple[tuple[str, Callable[[float], None]], ...] = (
        ("odometry", robot.odometry),
        ("sonar", robot.sonar),
        ("scan", robot.scan),
    )
    began = time.monotonic()
    for turn in range(int(seconds / PERIOD_S * len(steps))):
        time.sleep(max(0.0, began + turn * PERIOD_S / len(steps) - time.monotonic()))
        what, send = steps[turn % len(steps)]
        now = time.time()
        send(now)
        if what in sent:
            sent[what].append(now)
    return sent


class _Robot:
    """Stands in the middle of a square room, and answers who it is."""

    def __init__(self, bus: Bus) -> None:
        model = configs.read(configs.find("robots", MODEL))
        discs = [
            {"number": int(number), "x": x, "y": y, "heading": np.radians(degrees)}
            for number, x, y, degrees in model["sonar"]
        ]
        size = {name: model[f"{name}_m"] for name in ("radius", "width", "length_front", "length_rear")}
        place = {"x": 0.0, "y": 0.0, "z": 0.2, "heading": 0.0, "flipped": False}
        self._description: dict[str, Any] = {
            "name": ROBOT,
            "model": MODEL,
            "geometry": {**size, "sonar": discs},
            "limits": {"linear": 1.0, "angular": 2.0, "deceleration": 0.3},
            "elements": [{"name": "base"}, {"name": "laser", "geometry": place}],
        }
        self._bus = bus
        self._discs = discs
        bearings = np.linspace(-np.pi / 2.0, np.pi / 2.0, BEAMS)
        self._ranges = (WALL_M / np.maximum(np.abs(np.cos(bearings)), np.abs(np.sin(bearings)))).astype(np.float32)
        bus.serve(keys.DESCRIPTION.key(ROBOT), lambda arguments: self._description)

    def odometry(self, now: float) -> None:
        """It stands."""
        nothing = np.zeros(36)
        pose = Pose(position=Point(x=0.0, y=0.0, z=0.0), orientation=quaternion(0.0))
        message = Odometry(
            header=_header(now, "odom"),
            child_frame_id=f"{ROBOT}/base_link",
            pose=PoseWithCovariance(pose=pose, covariance=nothing),
            twist=TwistWithCovariance(twist=twist(0.0, 0.0), covariance=nothing),
        )
        self._bus.put(keys.ODOM.key(ROBOT), message)

    def sonar(self, now: float) -> None:
        """All discs at once."""
        readings = [
            Range(
                header=_header(now, f"sonar_{disc['number']}"),
                radiation_type=Range.ULTRASOUND,
                field_of_view=0.4,
                min_range=0.1,
                max_range=5.0,
                range=WALL_M - 0.25,
                variance=0.0,
            )
            for disc in self._discs
        ]
        self._bus.put(keys.SONAR.key(ROBOT), RangeArray(_header(now, "base_link"), readings))

    def scan(self, now: float) -> None:
        """As many beams as the published one had."""
        message = LaserScan(
            header=_header(now, "laser"),
            angle_min=-np.pi / 2.0,
            angle_max=np.pi / 2.0,
            angle_increment=np.pi / (BEAMS - 1),
            time_increment=0.0,
            scan_time=PERIOD_S,
            range_min=0.01,
            range_max=8.0,
            ranges=self._ranges,
            intensities=np.zeros(BEAMS, np.float32),
        )
        self._bus.put(keys.SCAN.key(ROBOT), message)


def _header(now: float, frame: str) -> Header:
    return header(round(now * 1e9), f"{ROBOT}/{frame}")

"""Recordings made for tests, without a robot and without waiting."""

from pathlib import Path
from typing import Any

import numpy as np

from bus import keys
from bus.bus import Sample
from bus.memory import MemoryBus
from bus.messages import (
    NS_PER_S,
    Odometry,
    Point,
    Pose,
    PoseWithCovariance,
    Twist,
    TwistWithCovariance,
    encode,
    header,
    quaternion,
    twist,
)
from recorder.recording import McapRecording, Recorded
from recorder.writer import RecordingWriter

START = 1_700_000_000 * NS_PER_S
NO_COVARIANCE = np.zeros(36)


def odometry(robot: str, x: float, stamp_ns: int, speed: float = 0.3) -> Odometry:
    """An odometry message of a robot at x, m."""
    pose = Pose(position=Point(x=x, y=0.5 * x, z=0.0), orientation=quaternion(0.0))
    moving: Twist = twist(speed, 0.0)
    return Odometry(
        header=header(stamp_ns, f"{robot}/odom"),
        child_frame_id=f"{robot}/base_link",
        pose=PoseWithCovariance(pose=pose, covariance=NO_COVARIANCE),
        twist=TwistWithCovariance(twist=moving, covariance=NO_COVARIANCE),
    )


def sample(key: str, message: object) -> Sample:
    """A message as it comes over the bus."""
    heard: list[Sample] = []
    with MemoryBus() as bus:
        bus.subscribe(key, heard.append)
        bus.put(key, message)
    return heard[0]


def drive(path: Path, seconds: float = 4.0, robot: str = "happy", **options: Any) -> list[Path]:
    """Record a drive: odometry, commands and a JSON stream at 10 Hz, a token and a description at the start.

    Returns:
        The files.
    """
    writer = RecordingWriter(path, "test", **options)
    writer.add_token(f"{robot}/alive", True, START)
    writer.add_description(f"{robot}/description", {"model": "p3dx-sh", "emulated": True}, START)
    for step in range(int(seconds * 10)):
        now = START + step * NS_PER_S // 10
        stamp = now - 20_000_000
        writer.add(sample(keys.ODOM.key(robot), odometry(robot, 0.03 * step, stamp)), now)
        writer.add(sample(keys.CMD_VEL.key(robot), twist(0.4, 0.0)), now)
        writer.add(sample(f"{robot}/agents/base/results", {"step": step}), now)
        writer.flush(now)
    writer.close()
    return writer.files


def read(*paths: Path) -> list[Recorded]:
    """All samples of a recording."""
    with McapRecording.open(paths) as recording:
        return list(recording.samples())


__all__ = ["START", "drive", "encode", "odometry", "read", "sample"]

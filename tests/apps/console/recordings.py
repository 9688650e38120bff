"""Recordings made for tests of the console, without a robot and without waiting."""

from pathlib import Path

from bus import keys
from bus.acromovi_msgs import RangeArray, RobotState
from bus.messages import NS_PER_S, header
from bus.ros_msgs import Range
from recorder.writer import RecordingWriter
from tests.recorder.recordings import START, odometry, sample

SECONDS = 8
ESTOP_AT, LEASE_AT, GONE_AT = 3.0, 2.0, 6.0  # s
DRIVEN = 0.1  # m/s
ELEMENTS = [{"name": name} for name in ("base", "sonar", "sound")]


def recorded_drive(path: Path) -> Path:
    """Record two robots: happy drives, is stopped and gets a lease; max goes away."""
    writer = RecordingWriter(path, "test")
    for robot in ("happy", "max"):
        writer.add_token(f"{robot}/alive", True, START)
        writer.add_description(
            f"{robot}/description", {"model": "p3dx-sh", "emulated": True, "elements": ELEMENTS}, START
        )
        writer.add_description(f"{robot}/lease/state", {"holder": None, "elements": {}}, START)
    for step in range(SECONDS * 10):
        at = step / 10
        now = START + round(at * NS_PER_S)
        if at == LEASE_AT:
            lease = {"holder": None, "elements": {"base": {"holder": "anna@team"}}}
            writer.add(sample(keys.LEASE_STATE.key("happy"), lease), now)
        if at == GONE_AT:
            writer.add_token("max/alive", False, now)
        writer.add(sample(keys.ODOM.key("happy"), odometry("happy", DRIVEN * at, now)), now)
        writer.add(sample(keys.SONAR.key("happy"), ranges(step % 4, at)), now)
        if step % 10 == 0:
            stamp = header(now, "")
            state = RobotState(stamp, "connected", True, ESTOP_AT <= at < ESTOP_AT + 1.0, True, 0, [])
            writer.add(sample(keys.STATE.key("happy"), state), now)
        writer.flush(now)
    writer.close()
    return path


def ranges(disc: int, far: float) -> RangeArray:
    """The range of one disc."""
    stamp = header(START, f"happy/sonar_{disc}")
    return RangeArray(header(START, ""), [Range(stamp, 0, 0.26, 0.1, 5.0, far, 0.0)])

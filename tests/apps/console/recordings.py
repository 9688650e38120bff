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
GOAL_AT, WAY_AT, PLAN_AT, THERE_AT = 4.5, 5.0, 6.0, 7.0  # s
DOOR = {"x": 1.0, "y": 0.5, "width": 0.9, "normal": 0.0, "confidence": 0.8}
GOAL = 2.0, 1.0  # m in odom
DRIVEN = 0.1  # m/s
ELEMENTS = [{"name": name} for name in ("base", "sonar", "sound")]


def recorded_drive(path: Path) -> Path:
    """Record two robots: happy drives, is stopped, gets a lease and has a mission; max goes away."""
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
        for key, message in mission_messages(at):
            writer.add(sample(f"happy/navigation/{key}", message), now)
        writer.flush(now)
    writer.close()
    return path


def mission_messages(at: float) -> list[tuple[str, dict[str, object]]]:
    """What the components of a navigation tell each other at a time, s, and noise on the same keys."""
    x, y = GOAL
    message = {"stamp": at, "component": "path_planning", "mission": "m1", "level": "info"}
    if at == GOAL_AT:
        return [("path_planning/send/GoalPoint", {"mission": "m1", "x": x, "y": y, "heading": None, "frame": "odom"})]
    if at == WAY_AT:
        way = {"stamp": at, "order": 1, "aim": "go", "x": x, "y": y, "path": [0.6, 0.3, 1.2, 0.9]}
        return [
            ("user_interface/send/LogMessage", {**message, "what": "going: the way leads ahead"}),
            ("user_interface/send/LogMessage", {**message, "what": "the fuser is silent: it is frozen"}),
            ("goto/send/WorldCoord", {"aim": "go", "x": "there", "path": {}}),
            ("goto/send/WorldCoord", way),
            ("user_interface/send/LogMessage", {"mission": 5, "what": ["noise"]}),
        ]
    if at == PLAN_AT:
        plan = {"stamp": at, "mission": "m1", "route": [0.6, 0.3, 1.2, 0.9, x, y, 3.0, 1.5, 7], "doors": [DOOR]}
        return [
            ("path_planning/push/PlannedWay", {"mission": "m1", "route": ["there"], "doors": "none"}),
            ("path_planning/push/PlannedWay", {**plan, "doors": [DOOR, {**DOOR, "x": None}, {"x": 1.0}, "door"]}),
        ]
    if at == THERE_AT:
        return [("user_interface/send/LogMessage", {**message, "what": "done: there, after 2.2 m"})]
    return []


def ranges(disc: int, far: float) -> RangeArray:
    """The range of one disc."""
    stamp = header(START, f"happy/sonar_{disc}")
    return RangeArray(header(START, ""), [Range(stamp, 0, 0.26, 0.1, 5.0, far, 0.0)])

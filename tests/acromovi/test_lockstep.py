"""Firmware, driver and bus in one process under a virtual clock: the whole chain in milliseconds."""

import math
from collections.abc import Iterator

import pytest

from acromovi.lockstep import Lockstep
from apps.waypoints import Follower
from bus import Bus, Refused, Sample, keys, messages
from geometry import Pose2D
from p2os_emu.world import load_world

ROBOT = "happy"


class Watched:
    """The last odometry of a robot, and how many came."""

    def __init__(self, bus: Bus) -> None:
        self.pose: Pose2D | None = None
        self.speed = 0.0
        self.count = 0
        self.stamps: list[int] = []
        bus.subscribe(keys.ODOM.key(ROBOT), self._on_odometry)

    def _on_odometry(self, sample: Sample) -> None:
        message = messages.decode(sample.type_name, sample.payload)
        position = message.pose.pose.position
        self.pose = Pose2D(position.x, position.y, messages.heading(message.pose.pose.orientation))
        self.speed = message.twist.twist.linear.x
        self.stamps.append(messages.stamp_ns(message.header))
        self.count += 1


@pytest.fixture
def lockstep() -> Iterator[Lockstep]:
    with Lockstep(load_world("empty"), {ROBOT: "p3dx-sh"}, perfect=True) as lockstep:
        lockstep.run(1.5)
        yield lockstep


def drive(lockstep: Lockstep, bus: Bus, linear: float, angular: float, seconds: float) -> None:
    for _ in range(round(seconds / 0.1)):
        bus.put(keys.CMD_VEL.key(ROBOT), messages.twist(linear, angular))
        lockstep.run(0.1)


def test_odometry_comes_with_every_sip_on_the_virtual_clock(lockstep: Lockstep) -> None:
    watched = Watched(lockstep.bus())
    lockstep.run(3.0)
    assert watched.count == 30
    gaps = {later - earlier for earlier, later in zip(watched.stamps, watched.stamps[1:], strict=False)}
    assert all(abs(gap - 100_000_000) < 10_000_000 for gap in gaps)


def test_a_twist_moves_the_robot_and_silence_stops_it(lockstep: Lockstep) -> None:
    bus = lockstep.bus()
    watched = Watched(bus)
    drive(lockstep, bus, 0.3, 0.0, 2.0)
    assert watched.speed == pytest.approx(0.3, abs=0.02)
    lockstep.run(2.5)
    assert watched.speed == 0.0
    stood_at = lockstep.truth(ROBOT)
    lockstep.run(2.0)
    assert lockstep.truth(ROBOT).x == pytest.approx(stood_at.x, abs=0.001)


def test_odometry_agrees_with_the_truth_of_a_perfect_robot(lockstep: Lockstep) -> None:
    bus = lockstep.bus()
    watched = Watched(bus)
    start = lockstep.truth(ROBOT)
    drive(lockstep, bus, 0.3, 0.4, 5.0)
    lockstep.run(3.0)
    assert watched.pose is not None
    believed, true = start.compose(watched.pose), lockstep.truth(ROBOT)
    assert math.hypot(believed.x - true.x, believed.y - true.y) < 0.02


def test_an_emergency_stop_outlasts_a_stream_of_twists(lockstep: Lockstep) -> None:
    bus = lockstep.bus()
    watched = Watched(bus)
    drive(lockstep, bus, 0.4, 0.0, 2.0)
    bus.query(keys.ESTOP.key(ROBOT), {"on": True})
    drive(lockstep, bus, 0.4, 0.0, 3.0)
    assert watched.speed == 0.0
    bus.query(keys.ESTOP.key(ROBOT), {"on": False})
    drive(lockstep, bus, 0.4, 0.0, 1.0)
    assert watched.speed == 0.0, "released, but not yet enabled"
    bus.query(keys.ENABLE.key(ROBOT), {"on": True})
    drive(lockstep, bus, 0.4, 0.0, 2.0)
    assert watched.speed > 0.3


def test_only_the_holder_of_the_lease_moves_the_robot(lockstep: Lockstep) -> None:
    bus = lockstep.bus()
    watched = Watched(bus)
    token = bus.query(keys.LEASE.key(ROBOT), {"do": "take", "holder": "someone", "seconds": 30})[0].value["token"]
    drive(lockstep, bus, 0.3, 0.0, 1.0)
    assert watched.speed == 0.0
    with pytest.raises(Refused, match="someone holds the lease"):
        bus.query(keys.MOVE.key(ROBOT), {"distance": 1.0})
    for _ in range(20):
        bus.put(keys.CMD_VEL.key(ROBOT), messages.twist(0.3, 0.0), token.encode())
        lockstep.run(0.1)
    assert watched.speed > 0.2


def test_a_move_ends_where_it_should_and_says_so(lockstep: Lockstep) -> None:
    bus = lockstep.bus()
    ends: list[dict[str, object]] = []
    bus.subscribe(f"{ROBOT}/command/result/*", lambda sample: ends.append(messages.decode_json(sample.payload)))
    start = lockstep.truth(ROBOT)
    answer = bus.query(keys.MOVE.key(ROBOT), {"distance": 1.0})[0].value
    assert answer["accepted"] is True
    lockstep.run_until(lambda: bool(ends), limit=15.0)
    lockstep.run(1.0)
    x, y = start.transform(1.0, 0.0)
    assert math.dist((x, y), (lockstep.truth(ROBOT).x, lockstep.truth(ROBOT).y)) < 0.01


def test_the_same_seed_gives_the_same_bytes_and_another_seed_others() -> None:
    def wire(seed: int) -> bytes:
        with Lockstep(load_world("office"), {ROBOT: "powerbot"}, seed=seed) as lockstep:
            bus = lockstep.bus()
            lockstep.run(1.5)
            drive(lockstep, bus, 0.3, 0.2, 3.0)
            return lockstep.wire(ROBOT)

    first = wire(1)
    assert first == wire(1)
    assert first != wire(2)


def test_an_application_drives_a_robot_round_the_office_without_a_bump() -> None:
    world = load_world("office")
    with Lockstep(world, {ROBOT: "powerbot"}, seed=1) as lockstep:
        bus = lockstep.bus()
        watched = Watched(bus)
        pressed: list[bool] = []
        bus.subscribe(
            keys.BUMPERS.key(ROBOT),
            lambda sample: pressed.append(any(messages.decode(sample.type_name, sample.payload).front)),
        )
        lockstep.run_until(lambda: watched.pose is not None, limit=3.0)
        start = lockstep.truth(ROBOT)
        follower = Follower(world.routes["round"])

        def arrived() -> bool:
            assert watched.pose is not None
            twist = follower.steer(start.compose(watched.pose))
            bus.put(keys.CMD_VEL.key(ROBOT), messages.twist(twist.linear, twist.angular))
            return follower.is_done

        lockstep.run_until(arrived, limit=90.0)
        assert pressed
        assert not any(pressed)


def test_two_robots_of_a_team_share_one_bus() -> None:
    with Lockstep(load_world("empty"), {"happy": "p3dx-sh", "grumpy": "amigo"}) as lockstep:
        bus = lockstep.bus()
        heard: set[str] = set()
        bus.subscribe("*/odom", lambda sample: heard.add(sample.key))
        lockstep.run(2.0)
        assert heard == {"happy/odom", "grumpy/odom"}


def scans(seed: int, seconds: float) -> list[bytes]:
    """What a robot with a laser publishes in the office."""
    heard: list[bytes] = []
    with Lockstep(load_world("office"), {ROBOT: "p3dx-sh"}, fits={ROBOT: "laser"}, seed=seed) as lockstep:
        lockstep.bus().subscribe(keys.SCAN.key(ROBOT), lambda sample: heard.append(sample.payload))
        lockstep.run(seconds)
    return heard


def test_scans_of_a_seed_are_always_the_same() -> None:
    first, again, other = scans(1, 4.0), scans(1, 4.0), scans(2, 4.0)
    assert len(first) > 30  # ten a second, once the laser is set up
    assert first == again
    assert first != other


def test_touches_people_and_doors_are_known_for_a_judge() -> None:
    with Lockstep(load_world("people-lab"), {ROBOT: "p3dx-sh"}, seed=1) as lockstep:
        lockstep.world.set_door("door", False)
        began = lockstep.world.people()["Anna"]
        lockstep.run(4.0)
        assert lockstep.world.touches(ROBOT).count == 0
        assert lockstep.world.doors()["door"].opening == 0.0
        assert lockstep.world.people()["Anna"].x > began.x + 1.0

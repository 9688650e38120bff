"""The robot as the bus sees it, in virtual time: firmware, driver, memory bus."""

import itertools
import json
import re
from collections.abc import Callable, Sequence
from math import inf, nan
from typing import TYPE_CHECKING, Any, TypeVar

import pytest

from bus import BusError, MemoryBus, NoAnswer, Refused, Sample, keys, messages
from bus.exchange import RawReply, Replies
from configs import load
from gateway.cables.cable import ElementCable, IsWanted, PublishEvents
from gateway.driver import Driver
from gateway.elements.powercube.driver import PowerCubeDriver
from gateway.errors import LineBlocked
from gateway.robot_on_bus import RobotOnBus
from gateway.settings import Settings
from p2os import RobotModel
from p2os.accessories.arm_model import ArmModel

if TYPE_CHECKING:
    from tests.gateway.conftest import Bench, MakeBench

T = TypeVar("T")
NS = 1_000_000_000


class Office:
    """A bench whose driver is on a bus, and a client on the same bus that hears everything."""

    def __init__(self, bench: "Bench", settings: Settings, cables: Sequence[ElementCable] = ()) -> None:
        self.bench = bench
        self.hangs = False  # the robot's port does
        self.posted: list[Callable[[Driver, float], object]] = []
        self.heard: dict[str, list[Sample]] = {}
        bench.connect()
        gateway_bus = MemoryBus()
        self.bus = MemoryBus(gateway_bus.network)
        self.bus.subscribe("happy/**", lambda sample: self.heard.setdefault(sample.key, []).append(sample))
        self.robot = RobotOnBus(
            "happy",
            gateway_bus,
            bench.driver,
            self,
            settings,
            cables=cables,
            new_token=map("token-{}".format, itertools.count(1)).__next__,
            wall_clock=lambda: self.stamp,
        )

    @property
    def stamp(self) -> int:
        return int(self.bench.now * NS)

    def command(self, give: Callable[[Driver, float], T]) -> T:
        if self.hangs:
            raise LineBlocked("the port hangs; the command was not sent")
        try:
            return give(self.bench.driver, self.bench.now)
        finally:
            self.bench.flush()

    def post(self, give: Callable[[Driver, float], object]) -> None:
        self.posted.append(give)

    def recover(self) -> None:
        """Let the robot's port work again."""
        self.hangs = False
        for give in self.posted:
            self.command(give)

    def run(self, seconds: float, each: Callable[[], None] | None = None) -> None:
        def tell() -> None:
            events = [event for at, event in self.bench.events if at == self.bench.now]
            self.robot.on_events(events, self.bench.now, self.stamp)
            if each is not None:
                each()

        self.bench.run(seconds, tell)

    def last(self, suffix: str) -> Any:
        sample = self.heard[f"happy/{suffix}"][-1]
        return messages.decode(sample.type_name, sample.payload)

    def objects(self, suffix: str) -> list[Any]:
        return [json.loads(sample.payload) for sample in self.heard.get(f"happy/{suffix}", [])]

    def ask(self, suffix: str, **arguments: object) -> dict[str, Any]:
        return self.bus.query(f"happy/{suffix}", arguments)[0].value

    def refusal(self, suffix: str, **arguments: object) -> str:
        with pytest.raises(Refused) as refused:
            self.ask(suffix, **arguments)
        return refused.value.why

    def drive(self, linear: float, angular: float = 0.0, token: str = "") -> None:
        self.bus.put("happy/cmd_vel", messages.twist(linear, angular), token.encode())


class HealthyCable:
    """The cable of an arm, which counts how often it was told to stop."""

    name = "arm"
    bridge = None

    def __init__(self) -> None:
        self.driver = PowerCubeDriver(load(ArmModel, "accessories", "powercube-arm"))
        self.halts = 0

    def join(self, publish: PublishEvents, is_wanted: IsWanted) -> None:
        """Nothing comes from it."""

    def halt(self) -> None:
        """Count."""
        self.halts += 1


@pytest.fixture
def make_office(make_bench: "MakeBench") -> Callable[[Settings], Office]:
    return lambda settings: Office(make_bench(settings=settings), settings)


@pytest.fixture
def office(make_office: Callable[[Settings], Office]) -> Office:
    return make_office(Settings())


def test_every_stream_of_the_elements_comes_with_its_type_at_its_rate(office: Office) -> None:
    office.run(0.15)
    office.heard.clear()
    office.run(2.0)
    rates = {key.removeprefix("happy/"): len(samples) for key, samples in office.heard.items()}
    every_sip = {"odom", "tf", "sonar", "sonar/points", "bumpers", "ir", "io"}  # an IOpac comes with each SIP
    every_second = {"battery", "state", "tf_static", "diagnostics"}
    assert set(rates) == every_sip | every_second
    assert {suffix: rates[suffix] for suffix in every_sip} == dict.fromkeys(every_sip, 20)
    assert all(2 <= rates[suffix] <= 4 for suffix in every_second)
    for key, samples in office.heard.items():
        topic = keys.topic_of(key)
        assert topic is not None
        assert samples[0].type_name == topic.type_name


def test_odometry_carries_frames_stamp_pose_and_covariance(office: Office) -> None:
    for _ in range(10):
        office.drive(0.5, 0.2)
        office.run(0.1)
    odom = office.last("odom")
    assert odom.header.frame_id == "happy/odom"
    assert odom.child_frame_id == "happy/base_link"
    assert abs(messages.stamp_ns(odom.header) - office.stamp) < 0.11 * NS
    assert odom.pose.pose.position.x > 0.05
    assert odom.twist.twist.linear.x > 0.1
    assert odom.pose.covariance[0] > 0.0
    assert odom.pose.covariance[35] > 0.0
    transform = office.last("tf").transforms[0]
    assert transform.child_frame_id == "happy/base_link"
    assert transform.transform.translation.x == odom.pose.pose.position.x


def test_sonar_gives_fresh_ranges_in_the_frames_of_their_discs_and_points_in_the_robots(office: Office) -> None:
    office.run(2.0)
    ranges = [each for sample in office.heard["happy/sonar"] for each in decoded(sample).ranges]
    by_frame = {each.header.frame_id: each.range for each in ranges}
    assert set(by_frame) == {f"happy/sonar_{n}" for n in range(31) if n % 8 != 7}
    assert by_frame["happy/sonar_1"] == inf  # the blocks' odd discs hear nothing
    assert by_frame["happy/sonar_2"] == pytest.approx(1.2, abs=0.01)
    assert {each.child_frame_id for each in office.last("tf_static").transforms} >= set(by_frame)
    cloud = office.last("sonar/points")
    assert cloud.header.frame_id == "happy/base_link"
    assert len(cloud.data) == 12 * cloud.width == cloud.row_step


def decoded(sample: Sample) -> Any:
    return messages.decode(sample.type_name, sample.payload)


def test_a_plain_twist_drives_and_half_a_second_of_silence_stops(office: Office) -> None:
    office.drive(0.3)
    office.run(0.3)
    assert office.bench.body.is_turning()
    office.run(3.0)
    assert not office.bench.body.is_turning()


def test_stamped_twist_drives_unless_its_stamp_is_old(office: Office) -> None:
    old = messages.TwistStamped(header=messages.header(office.stamp - NS, ""), twist=messages.twist(0.3, 0.0))
    office.bus.put("happy/cmd_vel_stamped", old)
    office.run(0.3)
    assert not office.bench.body.is_turning()
    ahead = messages.TwistStamped(header=messages.header(office.stamp + NS, ""), twist=messages.twist(0.3, 0.0))
    office.bus.put("happy/cmd_vel_stamped", ahead)
    office.run(0.3)
    assert not office.bench.body.is_turning()
    assert any("in the future" in fault for fault in office.last("state").faults)
    fresh = messages.TwistStamped(header=messages.header(office.stamp + NS // 10, ""), twist=messages.twist(0.3, 0.0))
    office.bus.put("happy/cmd_vel_stamped", fresh)
    office.run(0.3)
    assert office.bench.body.is_turning()


@pytest.mark.parametrize("payload", [b"", b"\x00\x01\x00\x00", bytes(51), bytes(60), bytes(10_000)])
def test_payload_that_is_no_twist_is_counted_and_moves_nothing(office: Office, payload: bytes) -> None:
    office.bus.deliver(Sample("happy/cmd_vel", payload, "application/cdr;geometry_msgs/msg/Twist"))
    office.run(1.1)
    assert not office.bench.body.is_turning()
    values = {each.key: each.value for status in office.last("diagnostics").status for each in status.values}
    assert values["refused: cmd_vel"] == "1"


def test_twist_of_nan_or_of_a_stream_under_estop_is_refused_and_shown(office: Office) -> None:
    office.drive(nan)
    office.run(0.1)
    assert any("not finite" in fault for fault in office.last("state").faults)
    assert office.ask("command/estop", on=True) == {"accepted": True, "estop": True}
    office.run(2.0, lambda: office.drive(0.5))
    assert not office.bench.body.is_turning()
    state = office.last("state")
    assert state.estop
    assert not state.motors
    assert "the e-stop is latched" in state.faults
    office.run(3.0)
    assert office.last("state").faults == ["the e-stop is latched"]


def test_move_answers_with_an_id_and_its_end_is_published_there(office: Office) -> None:
    answer = office.ask("command/move", distance=0.4)
    assert answer["accepted"] is True
    office.run(6.0)
    [end] = office.objects(f"command/result/{answer['id']}")
    assert end == {
        "id": answer["id"],
        "command": "move",
        "result": "reached",
        "done": pytest.approx(0.4, abs=0.03),
        "goal": 0.4,
        "unit": "m",
        "text": f"reached: {end['done']:.2f} of 0.40 m",
    }


def test_a_velocity_that_is_asked_drives_as_one_of_a_stream_does_and_says_why_not(office: Office) -> None:
    assert office.ask("command/drive", linear=0.3, angular=0.0) == {"accepted": True}
    office.run(0.4)
    assert office.last("odom").twist.twist.linear.x > 0.05
    office.run(2.0)
    assert not office.bench.body.is_turning()
    office.drive(0.3)
    office.ask("command/stop")
    assert "a stop holds the robot" in office.refusal("command/drive", linear=0.3, angular=0.0)


def test_sonar_output_stop_and_enable_are_obeyed(office: Office) -> None:
    office.ask("command/sonar", on=False)
    office.ask("command/output", mask=3, value=2)
    office.ask("command/enable", on=False)
    office.ask("command/stop")
    office.run(0.5)
    state = office.last("state")
    assert (state.connection, state.motors, state.sonar) == ("connected", False, False)
    assert list(office.last("io").digital_out[:2]) == [False, True]


@pytest.mark.parametrize(
    ("suffix", "arguments", "why"),
    [
        ("command/move", {}, "move needs distance: a number"),
        ("command/move", {"distance": "far"}, "distance of move must be a number"),
        ("command/move", {"distance": 1e999}, "finite"),
        ("command/move", {"distance": 10**400}, "finite"),
        ("command/move", {"distance": 1.0, "speed": 1}, "does not take 'speed'"),
        (
            "command/move",
            {"distanc": 1.0},
            r"move does not take 'distanc' \(did you mean distance\?\); it takes distance, token",
        ),
        ("command/turn", {"angle": True}, "must be a number"),
        ("command/enable", {"on": 1}, "true or false"),
        ("command/output", {"mask": 1.5, "value": 0}, "a whole number"),
        ("command/output", {"mask": 300, "value": 0}, "0 to 255"),
        ("lease", {"do": "steal"}, "cannot 'steal'"),
        ("lease", {"do": "take"}, "needs holder"),
        ("lease", {"do": ["take"]}, "cannot"),
    ],
)
def test_command_that_makes_no_sense_is_refused_in_one_sentence(
    office: Office, suffix: str, arguments: dict[str, object], why: str
) -> None:
    # As a foreign program may write it: our own encoder has no infinity to send.
    payload = json.dumps(arguments).encode()
    serving = next(entry for entry in office.bus.network.queryables if str(entry.key) == f"happy/{suffix}")
    replies: list[RawReply] = []
    serving.call(payload, replies.append, lambda: None)
    ends: list[BusError | None] = []
    heard = Replies(suffix, lambda answer: None, ends.append, 1.0)
    for reply in replies:
        heard.hear(reply)
    heard.end()
    (end,) = ends
    assert isinstance(end, Refused)
    assert re.search(why, end.why)
    office.run(0.2)
    assert not office.bench.body.is_turning()


class TestLease:
    def test_only_the_holders_token_moves_the_robot(self, office: Office) -> None:
        taken = office.ask("lease", do="take", holder="arbiter", seconds=5)
        office.run(0.5, lambda: office.drive(0.3))
        assert not office.bench.body.is_turning()
        assert "arbiter holds the lease" in office.refusal("command/move", distance=1.0)
        assert any("arbiter holds the lease" in fault for fault in office.last("state").faults)
        office.run(0.5, lambda: office.drive(0.3, token=taken["token"]))
        assert office.bench.body.is_turning()
        office.ask("command/move", distance=1.0, token=taken["token"])

    def test_anyone_may_stop_a_leased_robot(self, office: Office) -> None:
        taken = office.ask("lease", do="take", holder="arbiter")
        office.run(1.0, lambda: office.drive(0.3, token=taken["token"]))
        office.ask("command/stop")
        office.run(2.0, lambda: office.drive(0.3, token=taken["token"]))
        assert not office.bench.body.is_turning()
        assert office.ask("command/estop", on=True)["estop"]

    def test_robot_stops_when_the_lease_runs_out_although_the_stream_goes_on(self, office: Office) -> None:
        taken = office.ask("lease", do="take", holder="arbiter", seconds=1.0)
        office.run(0.9, lambda: office.drive(0.3, token=taken["token"]))
        assert office.bench.body.is_turning()
        office.run(2.0, lambda: office.drive(0.3, token=taken["token"]))
        assert not office.bench.body.is_turning()
        office.run(0.5, lambda: office.drive(0.3))
        assert office.bench.body.is_turning()

    def test_state_is_published_on_every_change_without_the_token(self, office: Office) -> None:
        office.run(0.1)
        token = office.ask("lease", do="take", holder="arbiter", priority=2, seconds=1.0)["token"]
        office.run(0.5)
        office.ask("lease", do="renew", token=token)
        office.run(2.0)
        states = office.objects("lease/state")
        assert [state["holder"] for state in states] == [None, "arbiter", None]
        assert token not in str(states)
        assert office.ask("lease") == {"holder": None, "priority": 0, "expires_in": None, "elements": {}}

    def test_lease_on_the_base_keeps_others_from_the_wheels_and_from_nothing_else(self, office: Office) -> None:
        token = office.ask("lease", do="take", holder="me", element="base")["token"]
        office.run(0.5, lambda: office.drive(0.3))
        assert not office.bench.body.is_turning()
        for suffix, given in (("move", {"distance": 1.0}), ("enable", {"on": False}), ("joystick", {"on": True})):
            assert "me holds the lease on the base" in office.refusal(f"command/{suffix}", **given)
        office.ask("command/servo", port=1, pulse=0.0015)
        office.ask("lease", do="take", holder="other", element="servos")
        office.run(0.5, lambda: office.drive(0.3, token=token))
        assert office.bench.body.is_turning()
        assert office.ask("command/stop")

    def test_lease_on_the_robot_and_leases_on_its_elements_yield_to_priority_alone(self, office: Office) -> None:
        base = office.ask("lease", do="take", holder="driver", element="base", priority=1)["token"]
        assert "driver holds the lease on the base" in office.refusal("lease", do="take", holder="all", priority=1)
        office.run(0.5, lambda: office.drive(0.3, token=base))
        robot = office.ask("lease", do="take", holder="all", priority=2)["token"]
        office.run(1.0, lambda: office.drive(0.3, token=base))
        assert not office.bench.body.is_turning()
        assert "all holds the lease on the robot" in office.refusal("lease", do="take", holder="x", element="base")
        office.ask("lease", do="release", token=robot)
        assert "has ended" in office.refusal("command/move", distance=1.0, token=base)

    def test_lease_is_on_what_moves(self, office: Office) -> None:
        assert "what moves is arm, base," in office.refusal("lease", do="take", holder="me", element="sonar")

    @pytest.mark.parametrize("how", ["expiry", "release", "pre-emption"])
    @pytest.mark.parametrize("element", ["base", "robot"])
    def test_long_motion_ends_with_the_lease_under_which_it_began(self, office: Office, how: str, element: str) -> None:
        token = office.ask("lease", do="take", holder="me", element=element, seconds=1.0)["token"]
        moving = office.ask("command/move", distance=5.0, detach=True, token=token)["id"]
        office.run(0.9)
        assert office.bench.body.is_turning()
        if how == "release":
            office.ask("lease", do="release", token=token)
        elif how == "pre-emption":
            office.ask("lease", do="take", holder="other", element="base", priority=1)
        office.run(0.2)
        assert [end["result"] for end in office.objects(f"command/result/{moving}")] == ["stopped"]
        office.run(2.0)
        assert not office.bench.body.is_turning()

    def test_motion_goes_on_when_a_lease_on_something_else_ends(self, office: Office) -> None:
        servos = office.ask("lease", do="take", holder="me", element="servos", seconds=0.5)["token"]
        base = office.ask("lease", do="take", holder="you", element="base")["token"]
        office.ask("command/move", distance=5.0, detach=True, token=base)
        office.run(1.5)
        assert "has ended" in office.refusal("command/servo", port=1, pulse=0.0015, token=servos)
        assert office.bench.body.is_turning()

    def test_token_of_the_past_is_refused_counted_and_shown(self, office: Office) -> None:
        stale = office.ask("lease", do="take", holder="me", element="base", seconds=0.1)["token"]
        office.run(0.5)
        office.run(0.5, lambda: office.drive(0.3, token=stale))
        assert not office.bench.body.is_turning()
        assert any("has ended" in fault for fault in office.last("state").faults)
        office.run(1.0)
        values = {each.key: each.value for status in office.last("diagnostics").status for each in status.values}
        assert int(values["refused: cmd_vel"]) > 50

    def test_state_lists_the_leases_on_elements(self, office: Office) -> None:
        token = office.ask("lease", do="take", holder="me", element="base", priority=3, seconds=1.0)["token"]
        office.run(0.2)
        (state,) = office.objects("lease/state")
        assert state["holder"] is None
        assert state["elements"]["base"] == {"holder": "me", "priority": 3, "expires_in": pytest.approx(1.0, abs=0.2)}
        assert token not in str(state)
        office.run(1.0)
        assert office.objects("lease/state")[-1]["elements"] == {}


def test_encoders_give_wheel_joints_when_the_settings_ask_for_them(make_office: Callable[[Settings], Office]) -> None:
    office = make_office(Settings(encoders=True))
    for _ in range(20):
        office.drive(0.3)
        office.run(0.1)
    joints = office.last("joint_states")
    assert joints.name == ["happy/left_wheel", "happy/right_wheel"]
    radius = load(RobotModel, "robots", "powerbot-sh").wheel_diameter / 2
    assert joints.position[0] == pytest.approx(office.bench.body.state.left_travel / radius, rel=0.1)
    assert joints.velocity[1] == pytest.approx(0.3 / radius, rel=0.05)


def test_io_packets_are_published_with_all_their_ports(make_office: Callable[[Settings], Office]) -> None:
    office = make_office(Settings(inputs_outputs=True))
    office.run(1.0)
    assert len(office.last("io").analog_in) > 0
    assert len(office.last("io").digital_in) >= 8


def test_description_names_model_elements_geometry_and_versions(make_office: Callable[[Settings], Office]) -> None:
    office = make_office(Settings(emulated=True))
    said = office.ask("description")
    assert (said["name"], said["model"], said["class"], said["emulated"]) == ("happy", "powerbot-sh", "Pioneer", True)
    always = {"base", "battery", "io", "sonar", "bumpers", "sound", "servos"}
    assert {element["name"] for element in said["elements"]} == always | {"ir", "power", "charger"}
    assert len(said["geometry"]["sonar"]) == 28
    assert said["versions"]["acromovi"]
    assert json.dumps(said)


def test_what_is_not_known_to_be_emulated_is_treated_as_real(office: Office) -> None:
    assert office.ask("description")["emulated"] is False


def test_lost_robot_is_shown_and_publishes_nothing(office: Office) -> None:
    office.bench.cut = True
    office.run(1.5)
    office.heard.clear()
    office.run(2.0)
    assert set(office.heard) == {"happy/state", "happy/tf_static", "happy/diagnostics"}
    assert office.last("state").connection == "connecting"
    assert "the robot is not connected" in office.last("state").faults


def test_nothing_is_left_on_the_bus_after_closing(office: Office) -> None:
    alive: dict[str, bool] = {}
    office.bus.watch_alive("*/alive", alive.__setitem__)
    assert alive == {"happy/alive": True}
    office.robot.close()
    assert alive == {"happy/alive": False}
    with pytest.raises(NoAnswer):
        office.ask("description")


@pytest.mark.parametrize(("command", "given"), [("stop", {}), ("estop", {"on": True})])
def test_a_stop_reaches_a_healthy_cable_although_the_port_of_the_robot_hangs_and_the_robot_when_it_works_again(
    make_bench: "MakeBench", command: str, given: dict[str, bool]
) -> None:
    cable = HealthyCable()
    office = Office(make_bench(), Settings(), (cable,))
    office.run(0.5, lambda: office.drive(0.3))
    office.hangs = True
    assert "hangs" in office.refusal(f"command/{command}", **given)
    assert cable.halts == 1
    office.recover()
    assert office.bench.driver.is_estopped == (command == "estop")
    assert not office.bench.driver.is_asked_to_move

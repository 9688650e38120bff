"""A bus with keys: who is let in, who may do what, and what one is told."""

import json
import shutil
import sys
from collections.abc import Callable, Iterator
from datetime import timedelta
from pathlib import Path
from typing import Any

import pytest
import zenoh

from acromovi.__main__ import main
from acromovi.children import emulator, gateway
from bus import BusUnavailable, NoAnswer, NotAllowed, Sample, ZenohBus, keys
from bus.messages import decode, twist
from bus.secure import Permit, Profile, admitting
from bus.session import configuration
from configs import ConfigError
from configs.loader import find, read
from tests.bus.secure_site import MEMBERS, ROOT, Site
from tests.waiting import run

Until = Callable[..., None]
Join = Callable[[str], ZenohBus]
VIEWERS_REFUSAL = "a viewer may read everything and move nothing; ask for an operator's key"
DAY = timedelta(days=1)


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Site]:
    """One router for all tests of this file; they do not change it."""
    site = Site(tmp_path_factory.mktemp("site") / "keys")
    site.make("router.lab")
    for member in MEMBERS:
        site.make(member)
    with site.routed():
        yield site


@pytest.fixture
def quiet_site(tmp_path: Path) -> Site:
    """Keys of a test's own, and no router."""
    return Site(tmp_path / "keys")


@pytest.fixture
def join(site: Site) -> Iterator[Join]:
    """Joins the bus as one of its members."""
    buses: list[ZenohBus] = []

    def join(owner: str, *, knows_its_role: bool = True) -> ZenohBus:
        bus = site.open(owner) if knows_its_role else ZenohBus(configuration(site.profile(owner)))
        buses.append(bus)
        return bus

    yield join
    for bus in buses:
        bus.close()


@pytest.fixture
def happy(join: Join) -> "Robot":
    return Robot(join("robot.happy"))


class Robot:
    """What a gateway does, in short."""

    def __init__(self, bus: ZenohBus) -> None:
        self.bus = bus
        self.driven: list[str] = []  # by whom, as the attachments say
        bus.serve("happy/description", lambda arguments: {"model": "p3dx-sh"})
        bus.serve("happy/command/stop", lambda arguments: {"accepted": True})
        bus.subscribe("happy/cmd_vel", self._drive)
        bus.declare_alive("happy/alive")

    def _drive(self, sample: Sample) -> None:
        self.driven.append(sample.attachment.decode())


def test_a_viewer_reads_everything(happy: Robot, join: Join, until: Until) -> None:
    viewer = join("viewer.vera")
    heard: list[str] = []
    tokens: list[str] = []
    viewer.subscribe("**", lambda sample: heard.append(sample.key))
    viewer.watch_alive("*/alive", lambda key, is_alive: tokens.append(key))

    def has_heard() -> bool:
        happy.bus.put("happy/odom", twist(0.0, 0.0))
        return "happy/odom" in heard

    until(has_heard)
    until(lambda: tokens == ["happy/alive"])
    assert viewer.query("happy/description")[0].value == {"model": "p3dx-sh"}
    assert [answer.key for answer in viewer.query("*/description")] == ["happy/description"]


def test_a_viewer_moves_nothing_and_is_told_so(happy: Robot, join: Join) -> None:
    viewer = join("viewer.vera")
    refused: list[Callable[[], object]] = [
        lambda: viewer.put("happy/cmd_vel", twist(0.1, 0.0)),
        lambda: viewer.send("happy/cmd_vel", twist(0.1, 0.0)),
        lambda: viewer.publisher("happy/cmd_vel", "geometry_msgs/msg/Twist"),
        lambda: viewer.query("happy/command/stop"),
        lambda: viewer.query("happy/lease"),
        lambda: viewer.ask("happy/agents/base/acl", {}, lambda answer: None, lambda error: None),
        lambda: viewer.converse("happy/agents/base/acl", lambda arguments, conversation: None),
        lambda: viewer.serve("happy/description", lambda arguments: {}),
        lambda: viewer.declare_alive("happy/alive"),
    ]
    for attempt in refused:
        with pytest.raises(NotAllowed) as caught:
            attempt()
        assert str(caught.value).startswith(VIEWERS_REFUSAL)
        assert isinstance(caught.value, PermissionError)


@pytest.mark.parametrize("owner", ["viewer.vera", "robot.grumpy"])
def test_the_router_stops_a_program_that_does_not_stop_itself(
    happy: Robot, join: Any, until: Until, owner: str
) -> None:
    rogue = join(owner, knows_its_role=False)
    operator = join("operator.anna")
    forged: list[str] = []
    operator.subscribe("happy/odom", lambda sample: forged.append(sample.key))

    def has_driven() -> bool:
        rogue.put("happy/odom", twist(0.0, 0.0))
        rogue.put("happy/cmd_vel", twist(0.1, 0.0), b"rogue")
        operator.put("happy/cmd_vel", twist(0.1, 0.0), b"operator")
        return len(happy.driven) >= 5

    until(has_driven)
    assert set(happy.driven) == {"operator"}
    assert forged == []
    with pytest.raises(NoAnswer):
        rogue.query("happy/command/stop", timeout=5.0)
    rogue.serve("happy/command/stop", lambda arguments: {"forged": True})
    assert [answer.value for answer in operator.query("happy/command/stop")] == [{"accepted": True}]


@pytest.mark.parametrize("owner", ["operator.anna", "admin.root"])
def test_those_who_may_move_robots_do(happy: Robot, join: Join, until: Until, owner: str) -> None:
    driver = join(owner)

    def has_driven() -> bool:
        driver.put("happy/cmd_vel", twist(0.1, 0.0))
        return bool(happy.driven)

    until(has_driven)
    assert driver.query("happy/command/stop")[0].value == {"accepted": True}


def test_an_operator_does_not_speak_for_a_robot(join: Join) -> None:
    with pytest.raises(NotAllowed, match="under the name anna only"):
        join("operator.anna").put("happy/odom", twist(0.0, 0.0))


def test_agents_of_robots_and_operators_talk_to_each_other(happy: Robot, join: Join) -> None:
    operator, viewer, grumpy = join("operator.anna"), join("viewer.vera"), join("robot.grumpy")
    happy.bus.serve("happy/agents/base/acl", lambda arguments: {"act": "agree"})
    operator.serve("anna/agents/tour/acl", lambda arguments: {"act": "propose"})
    for asker in operator, grumpy:
        assert asker.query("happy/agents/base/acl")[0].value == {"act": "agree"}
    assert grumpy.query("*/agents/tour/acl")[0].value == {"act": "propose"}
    with pytest.raises(NotAllowed, match="a viewer"):
        viewer.query("happy/agents/base/acl")


def test_a_gateway_with_a_robots_key_serves_viewer_and_operator(
    site: Site, join: Join, until: Until, capsys: pytest.CaptureFixture[str]
) -> None:
    viewer = join("viewer.vera")
    travelled: list[float] = []

    def hear(sample: Sample) -> None:
        travelled.append(decode(sample.type_name, sample.payload).pose.pose.position.x)

    viewer.subscribe("happy/odom", hear)
    with (
        emulator("--robot", "p3dx-sh:happy", "--quiet") as robots,
        gateway(robots.port, "--quiet", "--name", "happy", "--bus", site.profile("robot.happy")),
    ):
        until(lambda: travelled)
        assert main(["command", "happy", "move", "distance=0.2", "--bus", site.profile("viewer.vera")]) == 1
        assert capsys.readouterr().err.startswith(f"acromovi command: {VIEWERS_REFUSAL}")
        assert main(["command", "happy", "move", "distance=0.2", "--bus", site.profile("operator.anna")]) == 0
        until(lambda: travelled[-1] > 0.1)


def test_a_gateway_with_another_robots_key_ends_and_says_so(site: Site) -> None:
    with emulator("--robot", "p3dx-sh:happy", "--quiet") as robots:
        given = [robots.port, "--quiet", "--name", "happy", "--bus", site.profile("robot.grumpy")]
        done = run([sys.executable, "-m", "gateway", *given], cwd=ROOT)
    assert done.returncode == 2
    assert "cannot be happy on this bus: a robot may" in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize(
    "tls",
    [
        {},
        {"enable_mtls": True, "connect_certificate": "stray/cert.pem", "connect_private_key": "stray/key.pem"},
    ],
)
def test_a_stranger_cannot_connect(site: Site, tmp_path: Path, tls: dict[str, Any]) -> None:
    stray = Site(tmp_path / "stray").make("operator.anna")
    paths = {key: value.replace("stray", str(stray)) if value is not True else value for key, value in tls.items()}
    table = {
        "mode": "client",
        "connect": {"endpoints": [site.endpoint]},
        "scouting": {"multicast": {"enabled": False}},
        "transport": {"link": {"tls": {"root_ca_certificate": str(site.folder / "authority" / "ca.pem"), **paths}}},
    }
    with pytest.raises(zenoh.ZError, match="Unable to connect"):
        zenoh.open(zenoh.Config.from_json5(json.dumps(table)))


def test_a_key_of_another_authority_is_told(site: Site, quiet_site: Site) -> None:
    stray = quiet_site.make("operator.anna")
    with pytest.raises(BusUnavailable, match=r"router's certificate does not pass: .*is .*ca.pem of its authority\?"):
        ZenohBus.open(site.profile(str(stray)))
    shutil.copy(site.folder / "authority" / "ca.pem", stray)
    with pytest.raises(BusUnavailable, match="it has another authority than this certificate"):
        ZenohBus.open(site.profile(str(stray)))


def test_a_key_that_is_not_valid_now_is_told(site: Site, quiet_site: Site) -> None:
    past, future = site.now - 10 * DAY, site.now + 10 * DAY
    quiet_site.make("operator.old", past, DAY)
    with pytest.raises(BusUnavailable, match=r"the certificate of operator.old has expired on .*keys renew"):
        ZenohBus.open(site.profile(str(quiet_site.folder / "operator.old")))
    quiet_site.make("operator.early", future)
    with pytest.raises(BusUnavailable, match=r"certificate of operator.early is valid from .* not come yet"):
        ZenohBus.open(site.profile(str(quiet_site.folder / "operator.early")))


def test_a_key_whose_name_the_router_does_not_have_is_told(site: Site, quiet_site: Site) -> None:
    quiet_site.folder.mkdir()
    shutil.copytree(site.folder / "authority", quiet_site.folder / "authority")
    late = quiet_site.make("operator.late")
    with pytest.raises(BusUnavailable, match=r"^the router does not know operator.late.* start the router again$"):
        ZenohBus.open(site.profile(str(late)))


def test_a_router_that_is_not_there_is_told(quiet_site: Site) -> None:
    quiet_site.make("viewer.vera")
    with pytest.raises(BusUnavailable, match=r"^the bus cannot be opened: tls/127.* no router listens there"):
        quiet_site.open("viewer.vera")


def test_a_router_under_another_address_than_its_certificate_says_is_told(tmp_path: Path) -> None:
    site = Site(tmp_path / "keys", "127.0.0.2")
    site.make("router.lab")
    site.make("viewer.vera")
    with site.routed(), pytest.raises(BusUnavailable, match="IP address mismatch"):
        site.open("viewer.vera")


def test_routers_of_two_sites_join_and_each_checks_its_own(quiet_site: Site, until: Until) -> None:
    far = Site(quiet_site.folder)
    for owner in ("router.lab", "router.hall", *MEMBERS):
        quiet_site.make(owner)
    driven: list[str] = []
    with (
        quiet_site.routed(),
        ZenohBus(
            configuration(far.profile("router.hall", "secure-router"), {"connect/endpoints": [quiet_site.endpoint]})
        ),
        ZenohBus(configuration(far.profile("viewer.vera"))) as rogue,
        far.open("operator.anna") as operator,
        quiet_site.open("robot.happy") as robot,
    ):
        robot.subscribe("happy/cmd_vel", lambda sample: driven.append(sample.attachment.decode()))

        def has_driven() -> bool:
            rogue.put("happy/cmd_vel", twist(0.1, 0.0), b"rogue")
            operator.put("happy/cmd_vel", twist(0.1, 0.0), b"operator")
            return len(driven) >= 5

        until(has_driven)
    assert set(driven) == {"operator"}


def test_a_router_whose_certificate_has_expired_is_told(quiet_site: Site) -> None:
    quiet_site.make("router.lab", quiet_site.now - 10 * DAY, DAY)
    quiet_site.make("viewer.vera")
    with quiet_site.routed(), pytest.raises(BusUnavailable, match="certificate has expired"):
        quiet_site.open("viewer.vera")


def test_missing_keys_are_told_with_what_to_do(tmp_path: Path, quiet_site: Site) -> None:
    with pytest.raises(ConfigError, match=r"there is no ca\.pem in .*nowhere; make keys with `acromovi keys make`"):
        ZenohBus.open(f"secure:{tmp_path / 'nowhere'}")
    with pytest.raises(ConfigError, match="takes nothing behind its name, but got 'keys'"):
        ZenohBus.open("lan:keys")
    quiet_site.make("viewer.vera")
    with pytest.raises(ConfigError, match="there is no admitted in"):
        configuration(f"secure-router:{quiet_site.folder / 'viewer.vera'}")


def test_files_that_do_not_belong_together_are_told(quiet_site: Site) -> None:
    mixed = quiet_site.make("viewer.vera")
    shutil.copy(quiet_site.make("viewer.otto") / "key.pem", mixed)
    with pytest.raises(BusUnavailable, match=r"do not belong together"):
        quiet_site.open("viewer.vera")
    (mixed / "cert.pem").write_text("nonsense")
    with pytest.raises(ConfigError, match=r"cert.pem is no certificate"):
        quiet_site.open("viewer.vera")


def allows(permit: Permit, message: str, key: str) -> bool:
    try:
        permit.require(message, key)
    except NotAllowed:  # that is what is asked
        return False
    return True


@pytest.mark.parametrize("owner", MEMBERS)
def test_every_key_of_the_bus_is_for_those_it_is_meant_for(quiet_site: Site, owner: str) -> None:
    quiet_site.make(owner)
    permit = Permit.of(Profile.find(quiet_site.profile(owner)))
    assert permit is not None
    role = owner.partition(".")[0]
    is_self, moves = owner == "robot.happy", role in ("operator", "admin") or owner == "robot.happy"
    for topic in keys.TOPICS:
        key = topic.key("happy").replace("*", "1")
        assert allows(permit, "declare_subscriber", key)
        match topic.kind:
            case keys.Kind.STREAM:
                assert allows(permit, "put", key) == (is_self or role == "admin"), key
            case keys.Kind.COMMAND:
                assert allows(permit, "put", key) == moves, key
            case keys.Kind.QUERY:
                assert allows(permit, "query", key) == (moves or topic is keys.DESCRIPTION), key
                assert allows(permit, "declare_queryable", key) == (is_self or role == "admin"), key
            case keys.Kind.TOKEN:
                assert allows(permit, "liveliness_token", key) == (is_self or role == "admin"), key


def test_access_is_written_out_for_each_name_and_a_strange_name_gets_nothing() -> None:
    access = read(find("bus", "secure-router"))["access_control"]
    written = admitting(access, ["robot.happy", "robot.grumpy", "gardener.tom"])
    assert [subject["cert_common_names"] for subject in written["subjects"]] == [["robot.happy"], ["robot.grumpy"]]
    spoken = {rule["id"]: rule["key_exprs"] for rule in written["rules"] if rule["id"].startswith("speak")}
    assert spoken == {"speak robot.happy": ["happy/**"], "speak robot.grumpy": ["grumpy/**"]}
    assert written["default_permission"] == "deny"

"""Agents on a bus with keys: who may look at them, ask them and control them, and what one is told."""

import json
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from threading import Event
from typing import Any, ClassVar

import pytest

from acromovi.__main__ import main
from acromovi.team.host_control import HostControl
from agents import Refused, Team
from agents.components.component import ElementAgent
from agents.platform import AclMessage, AgentName, Performative, asker, request
from agents.platform.names import ContainerName
from apps.indoor_navigation.component import push_key, query_key, send_key
from apps.indoor_navigation.data import GoalPoint, MotionCmd
from bus import NoAnswer, NotAllowed, ZenohBus, keys
from bus.secure import Permit, Profile
from bus.session import configuration
from tests.acromovi.agents_alive import living
from tests.acromovi.conftest import AsOwner
from tests.bus.secure_site import MEMBERS, Site
from tests.waiting import patience

BASE = AgentName("base", "happy")
HOME = ContainerName("happy", "happy")
ROUTERS = ("router.lab", "router.hall")
VIEWERS_REFUSAL = "a viewer may read everything and move nothing; ask for an operator's key"
OPERATORS_REFUSAL = "an operator may read everything, move robots and ask agents, but"
ROBOTS_REFUSAL = "a robot may read everything and ask agents, but"

# Who may do what, beside the robot happy and the admin, who may do all of it.
EVERYBODY = frozenset({"viewer.vera", "operator.anna", "robot.grumpy"})
WHO_MAY_ASK = frozenset({"operator.anna", "robot.grumpy"})
OPERATOR: frozenset[str] = frozenset({"operator.anna"})
NOBODY: frozenset[str] = frozenset()
ALLOWED = {
    ("declare_subscriber", BASE.results_key): EVERYBODY,
    ("declare_subscriber", BASE.acl_key): EVERYBODY,
    ("declare_subscriber", HOME.said_key): EVERYBODY,
    ("declare_subscriber", HOME.reports_key): EVERYBODY,
    ("declare_liveliness_subscriber", BASE.alive_key): EVERYBODY,
    ("declare_liveliness_subscriber", HOME.alive_key): EVERYBODY,
    ("query", BASE.description_key): EVERYBODY,
    ("query", BASE.results_key): EVERYBODY,
    ("query", HOME.description_key): EVERYBODY,
    ("query", keys.LEASE_STATE.key("happy")): EVERYBODY,
    ("query", query_key("happy", "motion_fuser", "commands")): EVERYBODY,
    ("query", BASE.acl_key): WHO_MAY_ASK,
    ("put", BASE.acl_key): WHO_MAY_ASK,
    ("query", keys.LEASE.key("happy")): OPERATOR,
    ("query", keys.DRIVE.key("happy")): OPERATOR,
    ("put", keys.CMD_VEL.key("happy")): OPERATOR,
    ("query", HOME.control_key): NOBODY,
    ("put", push_key("happy", "motion_fuser", MotionCmd)): NOBODY,
    ("put", send_key("happy", "path_planning", GoalPoint)): NOBODY,
    ("put", BASE.results_key): NOBODY,
    ("put", HOME.said_key): NOBODY,
    ("put", HOME.reports_key): NOBODY,
    ("liveliness_token", BASE.alive_key): NOBODY,
    ("liveliness_token", HOME.alive_key): NOBODY,
    ("liveliness_token", keys.ELEMENT_ALIVE.key("happy", "laser")): NOBODY,
    ("declare_queryable", BASE.acl_key): NOBODY,
    ("declare_queryable", BASE.description_key): NOBODY,
    ("declare_queryable", HOME.control_key): NOBODY,
    ("reply", BASE.acl_key): NOBODY,
}


class Base(ElementAgent):
    """The base of a robot that is as fast as a thought."""

    results: ClassVar[Mapping[str, str]] = {"x": "m"}
    x = 0.0

    async def setup(self) -> None:
        await super().setup()
        self.every(0.05, self._send)

    async def _send(self) -> None:
        self.renew({"stamp": 1.0, "x": self.x, "y": 0.0, "heading": 0.0, "linear": 0.0, "angular": 0.0})

    @request("who")
    def who(self) -> str:
        return str(asker())

    @request("move")
    async def move(self, distance: float) -> dict[str, Any]:
        self.x += distance
        return {"x": self.x}


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Site]:
    """One router for all tests of this file, and behind it the robot happy with an agent."""
    site = Site(tmp_path_factory.mktemp("site") / "keys")
    for member in (*ROUTERS, *MEMBERS):
        site.make(member)
    with site.routed(), living("happy", Base(BASE), profile=site.profile("robot.happy")):
        yield site


@pytest.mark.parametrize("owner", MEMBERS)
def test_every_key_of_agents_is_for_those_it_is_meant_for(site: Site, owner: str) -> None:
    permit = Permit.of(Profile.find(site.profile(owner)))
    assert permit is not None
    for (message, key), others in ALLOWED.items():
        expected = owner in others or owner in ("robot.happy", "admin.root")
        assert permit.allows(message, key) is expected, (message, key)
    assert permit.allows("query", HostControl.key("dwarfs")) is (owner == "admin.root")


def test_a_viewer_sees_who_is_there_and_what_they_are(as_owner: AsOwner) -> None:
    code, shown, _ = as_owner("viewer.vera", "ps", "--json")
    assert code == 0
    assert [agent["name"] for agent in json.loads(shown)["agents"]] == ["base@happy"]
    code, shown, _ = as_owner("viewer.vera", "introspect", "base@happy", "--json")
    assert code == 0
    assert json.loads(shown)["container"] == "happy"


def test_a_viewer_reads_results_as_they_come_and_the_latest(site: Site, as_owner: AsOwner) -> None:
    code, shown, complaint = as_owner("viewer.vera", "ask", "base@happy", "read", "--json")
    assert (code, complaint) == (0, "")
    assert json.loads(shown).keys() == {"stamp", "x", "y", "heading", "linear", "angular"}
    with Team(site.profile("viewer.vera")) as team:
        base = team.robot("happy").element("base")
        assert base.read().stamp == 1.0
        assert next(base.watch()).stamp == 1.0


@pytest.mark.parametrize(
    "arguments",
    [
        ("ask", "base@happy", "move", "distance=0.1"),
        ("agent", "stop", "base@happy"),
        ("agent", "suspend", "base@happy"),
        ("agent", "start", "other@happy", "agents.components.generic:Generic", "--in", "happy"),
        ("command", "happy", "stop"),
        ("command", "happy", "lease", "do=take", "holder=vera"),
        ("container", "workshop"),
    ],
)
def test_a_viewer_is_told_that_it_moves_nothing(as_owner: AsOwner, arguments: tuple[str, ...]) -> None:
    code, _, complaint = as_owner("viewer.vera", *arguments)
    assert code == 1
    assert complaint.startswith(f"acromovi {arguments[0]}: {VIEWERS_REFUSAL}")


def test_a_viewers_program_is_told_that_it_moves_nothing(site: Site) -> None:
    refusal = pytest.raises(Refused, match=f"^move is not allowed: {VIEWERS_REFUSAL}")
    with Team(site.profile("viewer.vera")) as team, refusal:
        team.robot("happy").element("base").ask("move", distance=0.1)


@pytest.mark.parametrize("owner", ["viewer.vera", "robot.grumpy"])
def test_the_router_stops_a_program_that_does_not_stop_itself(
    site: Site, owner: str, until: Callable[..., None]
) -> None:
    is_viewer = owner == "viewer.vera"
    with ZenohBus(configuration(site.profile(owner))) as rogue, site.open("operator.anna") as operator:
        forged: list[str] = []
        operator.subscribe("happy/agents/forged/results", lambda sample: forged.append(sample.key))
        operator.watch_alive("happy/**", lambda key, is_alive: forged.append(key) if "forged" in key else None)
        rogue.declare_alive("happy/agents/forged/alive")
        rogue.declare_alive(keys.ELEMENT_ALIVE.key("happy", "forged"))
        rogue.serve("happy/agents/forged/description", lambda arguments: {"forged": True})
        assert "base@happy" in str(rogue.query(BASE.description_key)[0].value), "it may look"
        barred = [HOME.control_key, keys.LEASE.key("happy"), HostControl.key("dwarfs")]
        for key in [*barred, BASE.acl_key] if is_viewer else barred:
            with pytest.raises(NoAnswer):
                rogue.query(key, {"do": "list"}, timeout=5.0)
        if is_viewer:
            operator.subscribe(BASE.acl_key, lambda sample: forged.append(sample.key))
            rogue.send(BASE.acl_key, {"performative": "cancel"})
        rogue.put("happy/agents/forged/results", {"x": 99.0})
        with site.open("robot.grumpy") as grumpy:  # what it says comes later than anything forged would
            arrived: list[str] = []
            operator.subscribe("grumpy/agents/base/results", lambda sample: arrived.append(sample.key))

            def has_arrived() -> bool:
                grumpy.put("grumpy/agents/base/results", {"x": 1.0})
                return bool(arrived)

            until(has_arrived)
        with pytest.raises(NoAnswer):
            operator.query("happy/agents/forged/description")
        assert forged == []


def test_an_operator_asks_agents_and_programs_of_its_own_are_agents_of_its_name(site: Site, as_owner: AsOwner) -> None:
    code, shown, _ = as_owner("operator.anna", "ask", "base@happy", "move", "distance=0.5", "--json")
    assert (code, json.loads(shown)["x"] >= 0.5) == (0, True)
    with Team(site.profile("operator.anna")) as team:
        assert team.robot("happy").element("base").ask("move", distance=0.5)["x"] >= 0.5
        shown = as_owner("viewer.vera", "ps", "--json")[1]
        (mine,) = [each for each in json.loads(shown)["agents"] if each["name"] != "base@happy"]
        assert mine["name"].endswith("@anna")


def test_an_operator_controls_containers_of_its_own_name_only(site: Site, as_owner: AsOwner) -> None:
    with living("workshop", Base("bench@anna"), profile=site.profile("operator.anna")):
        code, shown, _ = as_owner("operator.anna", "agent", "suspend", "bench@anna")
        assert (code, shown) == (0, "bench@anna is suspended in workshop\n")
        code, _, complaint = as_owner("robot.grumpy", "agent", "stop", "bench@anna")
        assert code == 1
        assert complaint.startswith(f"acromovi agent: {ROBOTS_REFUSAL}")
    code, _, complaint = as_owner("operator.anna", "agent", "stop", "base@happy")
    assert code == 1
    assert complaint.startswith(f"acromovi agent: {OPERATORS_REFUSAL}")
    assert "under the name anna only; ask for an admin's key" in complaint


def test_a_robot_asks_agents_of_others_and_has_none_in_anothers_name(site: Site, as_owner: AsOwner) -> None:
    assert as_owner("robot.grumpy", "ask", "base@happy", "move", "distance=0.1")[0] == 0
    code, _, complaint = as_owner("robot.grumpy", "container", "--robot", "happy")
    assert code == 1
    assert complaint.startswith(f"acromovi container: {ROBOTS_REFUSAL}")
    assert "which is grumpy by this key" in complaint


@pytest.mark.parametrize("owner", ["operator.anna", "robot.grumpy"])
def test_who_may_not_speak_for_a_robot_is_told_so_before_its_navigation_is_started(
    as_owner: AsOwner, owner: str
) -> None:
    code, _, complaint = as_owner(owner, "navigate", "up", "happy")
    assert code == 1
    assert f"this key belongs to {owner.partition('.')[2]}, and the components run as happy" in complaint
    assert complaint.count("\n") == 1


def test_an_admin_controls_what_others_may_not(as_owner: AsOwner) -> None:
    for do, state in ("suspend", "suspended"), ("resume", "active"):
        assert as_owner("admin.root", "agent", do, "base@happy")[1] == f"base@happy is {state} in happy\n"


def test_a_folder_of_all_keys_is_told_from_ones_own(site: Site, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["ps", "--bus", site.profile("")]) == 1
    complaint = capsys.readouterr().err
    assert "it has the keys of several; say whose you use, as in --bus secure:" in complaint
    assert complaint.endswith(f"there are {', '.join(sorted((*MEMBERS, *ROUTERS)))}\n")


def test_a_promoted_program_is_called_after_the_owner_of_the_key(as_owner: AsOwner, tmp_path: Path) -> None:
    (tmp_path / "greet.py").write_text(
        'def main(team):\n    team.robot("happy").element("base").ask("move", distance=0.1)\n'
    )
    code, shown, complaint = as_owner("operator.anna", "promote", str(tmp_path / "greet.py"))
    assert (code, complaint) == (0, "")
    assert shown.startswith("greet@anna lives")


def test_who_asks_is_a_claim_that_no_key_proves_and_the_answer_goes_to_whoever_made_it(site: Site) -> None:
    claimed = AclMessage(
        performative=Performative.REQUEST,
        sender=AgentName("app", "anna"),
        receivers=(BASE,),
        content={"action": "who"},
        conversation_id="forged",
    )
    replies: list[str] = []
    with site.open("robot.grumpy") as grumpy, site.open("operator.anna") as anna:
        anna.subscribe("anna/**", lambda sample: replies.append(sample.key))
        with pytest.raises(NotAllowed, match="which is grumpy by this key"):
            grumpy.declare_alive("anna/agents/app/alive")
        ended = Event()
        heard: list[dict[str, Any]] = []
        grumpy.ask(BASE.acl_key, claimed.to_dict(), lambda answer: heard.append(answer.value), lambda why: ended.set())
        assert ended.wait(patience())
    assert [reply["performative"] for reply in heard] == ["agree", "inform"]
    assert heard[-1]["content"] == "app@anna"
    assert replies == []


def test_agents_are_asked_from_another_site_by_those_who_may(site: Site) -> None:
    far = Site(site.folder)
    link = configuration(far.profile("router.hall", "secure-router"), {"connect/endpoints": [site.endpoint]})
    with (
        ZenohBus(link),
        Team(far.profile("operator.anna")) as team,
        ZenohBus(configuration(far.profile("viewer.vera"))) as rogue,
    ):
        assert team.robot("happy").element("base").ask("move", distance=0.1)["x"] > 0.0
        assert rogue.query(BASE.description_key)[0].value["name"] == "base@happy"
        with pytest.raises(NoAnswer):
            rogue.query(BASE.acl_key, timeout=5.0)

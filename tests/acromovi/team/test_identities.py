"""Whose keys the processes of a team use, and a team on a bus with keys, with real processes."""

import json
import signal
from pathlib import Path

import pytest

from acromovi.team.host_control import HostControl
from acromovi.team.identities import TeamOptions, folder_of_keys
from acromovi.team.plan import TeamPlan, TeamProcesses
from bus import NotAllowed, keys
from configs import ConfigError
from tests.acromovi.conftest import AsOwner
from tests.acromovi.team.running import running
from tests.bus.secure_site import Site

TEAM = """\
world = "empty"

[[robots]]
name = "happy"
model = "p2dx"
"""
OWNERS = ("router.lab", "viewer.vera", "operator.anna", "robot.happy", "admin.dwarfs")


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Site:
    site = Site(tmp_path_factory.mktemp("site") / "keys")
    for owner in OWNERS:
        site.make(owner)
    return site


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("team") / "dwarfs.toml"
    path.write_text(TEAM)
    return path


def test_without_keys_all_come_to_the_bus_alike() -> None:
    assert folder_of_keys("local", "dwarfs", ["happy"]) is None
    assert TeamOptions("lan").bus_of_robot("happy") == "lan"


def test_each_process_comes_with_its_own_key(site: Site, file: Path) -> None:
    profile = site.profile("")
    team = TeamPlan.load(str(file))
    (robot,) = team.robots
    choices = TeamOptions(profile, keys=folder_of_keys(profile, team.name, [robot.name]))
    processes = TeamProcesses(team, choices, file.parent)
    programs = {
        processes.gateway(robot, {}): "robot.happy",
        processes.container("happy"): "robot.happy",
        processes.services(): "admin.dwarfs",
    }
    for program, owner in programs.items():
        bus = program.command[program.command.index("--bus") + 1]
        assert bus == site.profile(owner), program.name


def test_keys_that_are_missing_are_told_with_the_commands_that_make_them(site: Site) -> None:
    with pytest.raises(ConfigError) as caught:
        folder_of_keys(site.profile(""), "giants", ["happy", "grumpy"])
    told = str(caught.value)
    assert "the keys of robot.grumpy, admin.giants; make them, and start the router again: " in told
    assert "acromovi keys make --role robot --name grumpy --out " in told
    assert "acromovi keys make --role admin --name giants --out " in told


def test_one_key_serves_if_it_is_an_admins(site: Site) -> None:
    assert folder_of_keys(site.profile("admin.dwarfs"), "dwarfs", ["happy"]) is None
    with pytest.raises(ConfigError, match=r"the key of operator.anna, which may not speak for a whole team; give the"):
        folder_of_keys(site.profile("operator.anna"), "dwarfs", ["happy"])


def test_a_team_on_a_secure_bus_serves_those_who_may(site: Site, file: Path, as_owner: AsOwner) -> None:
    as_operator = site.profile("operator.anna")
    with site.routed(), running(str(file), bus=site.profile(""), seen_as=as_operator) as team:
        assert team.announced["robots"] == ["happy"]
        code, shown, _ = as_owner("operator.anna", "ask", "base@happy", "move", "distance=0.1", "--json")
        assert (code, json.loads(shown)["x"]) == (0, pytest.approx(0.1, abs=0.05))
        code, shown, _ = as_owner("operator.anna", "ask", "arbiter@dwarfs", "lease", "element=base@happy", "--json")
        assert (code, json.loads(shown)["element"]) == (0, "base@happy"), "the arbiter has it from the gateway"
        code, shown, _ = as_owner("viewer.vera", "ask", "sonar@happy", "read", "--json")
        assert (code, "ranges" in json.loads(shown)) == (0, True)
        assert as_owner("viewer.vera", "leases", "--json")[:2] == (0, '{"leases": []}\n')
        for request in ("ask", "base@happy", "move", "distance=0.1"), ("command", "happy", "stop"):
            code, _, complaint = as_owner("viewer.vera", *request)
            assert code == 1
            assert "a viewer may read everything and move nothing; ask for an operator's key" in complaint
        for barred in HostControl.key("dwarfs"), "happy/containers/happy/control":
            with pytest.raises(NotAllowed, match="ask for an admin's key"):
                team.bus.query(barred, {"do": "list"})
        with site.open("admin.dwarfs") as admin:
            assert admin.query(HostControl.key("dwarfs"), {"do": "status"})[0].value["team"] == "dwarfs"
            assert admin.query(keys.DESCRIPTION.key("happy"))[0].value["emulated"] is True
        team.end(signal.SIGINT)
        assert team.left_behind() == []

"""Models, names and ports of the robots of a run."""

from collections.abc import Iterator
from pathlib import Path

import pytest

import configs
from configs import ConfigError
from p2os_emu.emulator import EmulatedRobot, Emulator
from p2os_emu.links.line import LinkProfile
from p2os_emu.links.link import PortError
from p2os_emu.links.memory import MemoryLink
from p2os_emu.links.poller import Poller
from p2os_emu.ports import Ports
from p2os_emu.recording import RecordingError
from p2os_emu.team import EmulatedTeam
from tests.p2os_emu.flat_world import FlatWorld


@pytest.fixture
def poller() -> Iterator[Poller]:
    poller = Poller()
    yield poller
    poller.close()


@pytest.fixture
def team(poller: Poller) -> Iterator[EmulatedTeam]:
    emulator = Emulator(FlatWorld(), LinkProfile("ideal"))
    yield EmulatedTeam(emulator, Ports(poller, tcp=0), "ideal", {}, "")
    emulator.close()


@pytest.mark.parametrize(
    ("texts", "names"),
    [
        (["powerbot"], ["powerbot"]),
        (["powerbot", "powerbot", "powerbot"], ["powerbot", "powerbot-2", "powerbot-3"]),
        (["p3dx:powerbot", "powerbot"], ["powerbot", "powerbot-2"]),
        (["p3dx:Happy.1", "p2d8+:a+b_c-d"], ["Happy.1", "a+b_c-d"]),
        (["powerbot-sh-uarcs"] * 2, ["powerbot-sh-uarcs", "powerbot-sh-uarcs-2"]),
    ],
)
def test_every_robot_has_a_name_of_its_own(team: EmulatedTeam, texts: list[str], names: list[str]) -> None:
    assert [team.add(text, link=MemoryLink()).name for text in texts] == names


@pytest.mark.parametrize("name", configs.names("robots"))
def test_every_model_can_be_had_by_its_name(team: EmulatedTeam, name: str) -> None:
    assert team.add(name, link=MemoryLink()).model.name == name


@pytest.mark.parametrize("name", ["", "a/b", "a b", "a*", "$", "?", "#", "café", "x" * 20, "a:b"])
def test_name_that_handshake_or_bus_cannot_carry_is_refused(team: EmulatedTeam, name: str) -> None:
    with pytest.raises(ConfigError, match="will not do; use 1 to 19 letters"):
        team.add(f"p3dx:{name}", link=MemoryLink())


def test_unknown_model_names_the_nearest(team: EmulatedTeam) -> None:
    with pytest.raises(ConfigError, match="powerbot"):
        team.add("powerbott", link=MemoryLink())


def test_several_robots_share_one_path_by_name(poller: Poller, tmp_path: Path) -> None:
    ports = Ports(poller, pty=tmp_path / "robot", robots=2)
    links = [ports.open(name) for name in ("happy", "grumpy")]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["robot-grumpy", "robot-happy"]
    for link in links:
        link.close()


def test_single_robot_has_the_path_itself_and_later_ones_their_name(poller: Poller, tmp_path: Path) -> None:
    ports = Ports(poller, pty=tmp_path / "robot")
    links = [ports.open(name) for name in ("happy", "grumpy")]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["robot", "robot-grumpy"]
    for link in links:
        link.close()


def test_tcp_ports_follow_each_other(poller: Poller) -> None:
    probe = Ports(poller, tcp=0).open("probe")
    first = int(probe.port.rsplit(":", 1)[1])
    probe.close()
    ports = Ports(poller, tcp=first)
    assert [_number(ports, name) for name in ("happy", "grumpy")] == [first, first + 1]


def _number(ports: Ports, name: str) -> int:
    try:
        link = ports.open(name)
    except PortError as error:
        # Another program has the number: which number was tried is still what counts.
        return int(str(error).removeprefix("TCP port ").partition(" ")[0])
    link.close()
    return int(link.port.rsplit(":", 1)[1])


def test_flash_parameter_that_does_not_exist_is_reported_with_its_file(poller: Poller) -> None:
    emulator = Emulator(FlatWorld(), LinkProfile("ideal"))
    team = EmulatedTeam(emulator, Ports(poller, tcp=0), "ideal", {"host_bored": 1}, "my.toml")
    with pytest.raises(ConfigError, match=r"my\.toml: FLASH has no parameter 'host_bored'"):
        team.add("p3dx")


def test_flash_parameters_reach_the_robot(poller: Poller) -> None:
    emulator = Emulator(FlatWorld(), LinkProfile("ideal"))
    robot = EmulatedTeam(emulator, Ports(poller, tcp=0), "ideal", {"host_baud": 38400}, "my.toml").add("p3dx")
    assert robot.microcontroller.board.host_baud == 38400
    emulator.close()


@pytest.mark.parametrize("error", [RecordingError("the disk is full"), PortError("there is no port for a camera")])
def test_robot_that_cannot_be_completed_is_taken_away_again(poller: Poller, error: Exception) -> None:
    emulator = Emulator(FlatWorld(), LinkProfile("ideal"))
    team = EmulatedTeam(emulator, Ports(poller, tcp=0), "ideal", {}, "")

    def complain(robot: EmulatedRobot) -> None:
        raise error

    team.whenever_added.append(complain)
    with pytest.raises((ConfigError, PortError), match=str(error)):
        team.add("p3dx")
    assert not emulator.robots


def test_robot_named_has_a_line_of_its_own(poller: Poller) -> None:
    emulator = Emulator(FlatWorld(), LinkProfile("ideal"))
    team = EmulatedTeam(emulator, Ports(poller, tcp=0), "ideal", {}, "", links={"doc": "rs232"})
    happy, doc = team.add("p3dx:happy"), team.add("p3dx:doc")
    assert (team.entry(happy)["link"], team.entry(doc)["link"]) == ("ideal", "rs232")
    team.check_fits()
    with pytest.raises(ConfigError, match=r"--link dock=.*there is no robot 'dock'"):
        EmulatedTeam(emulator, Ports(poller, tcp=0), "ideal", {}, "", links={"dock": "rs232"}).check_fits()
    emulator.close()

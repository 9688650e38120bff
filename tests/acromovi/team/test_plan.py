"""From a team's file to the processes that make it up."""

from dataclasses import replace
from pathlib import Path

import pytest

from acromovi.team.identities import TeamOptions
from acromovi.team.plan import ProcessKind, TeamPlan, TeamProcesses
from bus import KeyNotValid
from configs import ConfigError
from configs.camera_calibration import CameraCalibration
from gateway.__main__ import parse_arguments
from gateway.settings import load_settings

DWARFS = """\
link = "rs232"

[[robots]]
name = "happy"
model = "p3dx-sh"
fit = ["laser"]

[[robots]]
name = "grumpy"
model = "p2dx"
link = "radio-modem"

[[robots]]
name = "iron"
model = "p3dx"
port = "/dev/ttyUSB7"
laser = "/dev/ttyUSB8"
link = "radio-modem"
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "dwarfs.toml"
    path.write_text(DWARFS)
    return path


def options(command: tuple[str, ...]) -> dict[str, str]:
    """Each option of a command line with the word behind it."""
    return {word: after for word, after in zip(command, (*command[1:], ""), strict=True) if word.startswith("--")}


def test_team_is_called_as_its_file(file: Path) -> None:
    team = TeamPlan.load(str(file))
    assert (team.name, [robot.name for robot in team.emulated]) == ("dwarfs", ["happy", "grumpy"])
    assert TeamPlan.load("acromovi").name == "acromovi"


def test_some_robots_of_a_team_are_had_without_the_others(file: Path) -> None:
    team = TeamPlan.load(str(file), ["iron", "grumpy"])
    assert [robot.name for robot in team.robots] == ["grumpy", "iron"]
    assert options(TeamProcesses(team, TeamOptions(), Path("f")).emulator().command)["--only"] == "grumpy"


def test_emulator_is_given_team_ports_and_seed(file: Path, tmp_path: Path) -> None:
    program = TeamProcesses(TeamPlan.load(str(file)), TeamOptions(seed=7), tmp_path).emulator()
    given = options(program.command)
    assert (given["--team"], given["--seed"], given["--only"]) == (str(file), "7", "happy,grumpy")
    assert (given["--control"], given["--pty"]) == (str(tmp_path / "control"), str(tmp_path / "port"))
    assert program.stage is ProcessKind.EMULATOR


def test_gateway_of_an_emulated_robot_is_told_where_the_emulator_has_put_it(file: Path, tmp_path: Path) -> None:
    team = TeamPlan.load(str(file))
    ports = {"port": "/dev/pts/5", "laser_port": "/dev/pts/6", "arm_port": None, "camera_url": "http://x/video"}
    program = TeamProcesses(team, TeamOptions(bus="lan"), tmp_path).gateway(team.robots[0], ports)
    given = options(program.command)
    assert program.command[3] == "/dev/pts/5"
    assert (given["--name"], given["--bus"], given["--laser"]) == ("happy", "lan", "/dev/pts/6")
    assert (given["--camera"], given["--config"]) == ("http://x/video", str(tmp_path / "emulated.toml"))
    assert not {"--arm", "--radio"} & given.keys()
    assert program.stage is ProcessKind.GATEWAY


def test_emulated_robots_share_a_gateway_unless_the_file_or_their_keys_separate_them(
    file: Path, tmp_path: Path
) -> None:
    team = TeamPlan.load(str(file))
    ports = {"happy": {"port": "/dev/pts/5"}, "grumpy": {"port": "/dev/pts/6", "laser_port": "/dev/pts/7"}}
    (program,) = TeamProcesses(team, TeamOptions(bus="lan"), tmp_path).gateways(ports)
    assert (program.robots, program.robot, program.stage) == (("happy", "grumpy"), "", ProcessKind.GATEWAY)
    settings = ["--config", str(tmp_path / "emulated.toml")]
    happy = ["/dev/pts/5", "--name", "happy", *settings]
    grumpy = ["/dev/pts/6", "--name", "grumpy", "--laser", "/dev/pts/7", "--radio", *settings]
    assert list(program.command[3:]) == [*happy, *grumpy, "--bus", "lan", "--json", "--wait"]
    assert [each.name for each in parse_arguments(program.command[3:])] == ["happy", "grumpy"]

    file.write_text('gateways = "separate"\n' + file.read_text())
    separate = TeamPlan.load(str(file))
    for plan, choices in ((separate, TeamOptions()), (team, TeamOptions("secure", keys=tmp_path))):
        programs = TeamProcesses(plan, choices, tmp_path).gateways(ports)
        assert [program.name for program in programs] == ["the gateway of happy", "the gateway of grumpy"]
    file.write_text(file.read_text().replace("separate", "both"))
    with pytest.raises(ConfigError, match=r"gateways must be one of shared, separate, not 'both'"):
        TeamPlan.load(str(file))


def test_gateway_behind_radio_modems_is_told_so(file: Path, tmp_path: Path) -> None:
    team = TeamPlan.load(str(file))
    assert "--radio" in TeamProcesses(team, TeamOptions(), tmp_path).gateway(team.robots[1], {"port": "x"}).command


def test_gateway_of_a_real_robot_is_told_what_the_file_says_and_not_that_it_is_emulated(
    file: Path, tmp_path: Path
) -> None:
    team = TeamPlan.load(str(file))
    command = TeamProcesses(team, TeamOptions(), tmp_path).gateway(team.robots[2], {}).command
    assert (command[3], options(command)["--laser"]) == ("/dev/ttyUSB7", "/dev/ttyUSB8")
    assert "--radio" in command
    assert "--wait" in command
    assert "--config" not in command


def test_gateway_of_a_robot_with_a_calibrated_camera_reads_it_from_settings_of_its_own(
    file: Path, tmp_path: Path
) -> None:
    known = CameraCalibration(160, 120, 150.0, 151.0, 79.0, 60.0, (-0.2, 0.1, 0.01, 0.02, 0.0), 0.3)
    team = TeamPlan.load(str(file))
    robots = tuple(replace(robot, camera_calibration=known) for robot in team.robots)
    plan = TeamProcesses(replace(team, file=replace(team.file, robots=robots)), TeamOptions(), tmp_path)
    plan.write_settings()
    for robot, is_emulated in (robots[0], True), (robots[2], None):
        config = options(plan.gateway(robot, {"port": "x"}).command)["--config"]
        settings = load_settings(Path(config))
        assert (settings.camera.calibration, settings.emulated) == (known, is_emulated)
    assert load_settings(tmp_path / "emulated.toml").camera.calibration is None


def test_containers_are_those_of_each_robot_and_one_of_the_team(file: Path, tmp_path: Path) -> None:
    team = TeamPlan.load(str(file))
    happy = TeamProcesses(team, TeamOptions(bus="lan"), tmp_path).container("happy")
    assert (happy.container, options(happy.command)["--robot"]) == ("happy", "happy")
    services = TeamProcesses(team, TeamOptions(apps=(tmp_path,)), tmp_path).services()
    assert (services.container, options(services.command)["--services"]) == ("services", "dwarfs")
    assert options(services.command)["--apps"] == str(tmp_path)
    assert happy.stage is services.stage is ProcessKind.AGENTS


def test_a_robot_that_navigates_has_the_processes_of_its_wiring(file: Path) -> None:
    file.write_text(DWARFS.replace('model = "p2dx"', 'model = "p2dx"\nnavigation = true'))
    team = TeamPlan.load(str(file))
    assert [robot.name for robot in team.robots if robot.navigation] == ["grumpy"]
    programs = TeamProcesses(team, TeamOptions("lan"), file.parent).navigation("grumpy")
    assert "grumpy-hardware" in [program.container for program in programs]
    assert all(program.stage is ProcessKind.AGENTS and program.robot == "grumpy" for program in programs)
    assert programs[0].command[3:] == ("navigate", "process", "grumpy", "hardware", "--bus", "lan", "--json")


def test_services_are_given_the_properties_of_the_teams_file(file: Path) -> None:
    file.write_text(DWARFS + '[services.arbiter]\naudit_file = "who moved what.jsonl"\n')
    services = TeamProcesses(TeamPlan.load(str(file)), TeamOptions(), file.parent).services()
    assert options(services.command)["--property"] == 'arbiter.audit_file="who moved what.jsonl"'


@pytest.mark.parametrize(
    ("text", "why"),
    [
        (DWARFS.replace("fit =", "fitt ="), "unknown key robots.0..fitt; did you mean robots.0..fit"),
        (DWARFS.replace("iron", "happy"), "two robots are called happy"),
        (DWARFS.replace("iron", "dwarfs"), "a robot is called dwarfs as the team is"),
        (DWARFS.replace("iron", "services"), "give it another name"),
        (DWARFS.replace("p2dx", "p2dxx"), "there is no 'p2dxx' among the robots; did you mean"),
        (DWARFS.replace("/dev/ttyUSB7", ""), 'the port of iron is empty; give a device, a URL or "emu"'),
        (DWARFS.replace("radio-modem", "radio"), "there is no 'radio' among the links; did you mean"),
        (DWARFS + "[services.arbitre]\n", "there is no service 'arbitre'; did you mean 'arbiter'"),
        ("robots = []", "a team needs a robot"),
        ("about = 'x'", "key robots is missing"),
        ("robots = 3", "robots must be a list"),
        ("[[robots]", "is not TOML"),
    ],
)
def test_mistake_in_a_teams_file_is_told_in_one_sentence(file: Path, text: str, why: str) -> None:
    file.write_text(text)
    with pytest.raises(ConfigError, match=why) as caught:
        TeamPlan.load(str(file))
    assert "\n" not in str(caught.value)


def test_name_that_the_bus_cannot_carry_is_refused(file: Path) -> None:
    file.write_text(DWARFS.replace("iron", "i/ron"))
    with pytest.raises(KeyNotValid, match="'i/ron' cannot name a robot"):
        TeamPlan.load(str(file))


def test_robot_that_a_team_does_not_have_cannot_be_chosen(file: Path) -> None:
    with pytest.raises(ConfigError, match="no robot 'hapy' in this team; did you mean 'happy'"):
        TeamPlan.load(str(file), ["hapy"])


def test_team_that_is_not_there_names_the_nearest() -> None:
    with pytest.raises(ConfigError, match="acromovi"):
        TeamPlan.load("acromov")

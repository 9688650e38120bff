"""What the pages of the documentation show to be run, apart from README, the tutorial and the page on own agents."""

import re

from tests.live_team import ROOT
from tests.reader import blocks

FOLLOWED = ("own-agents", "tutorial")  # whose tests do all that they show, in order
PAGES = [page.stem for page in sorted((ROOT / "docs").glob("*.md")) if page.stem not in FOLLOWED]
PROGRAMS = ("acromovi", "p2os-emu", "p2os-gateway", "pytest", "python")
OF_A_RECORDING = "acromovi wire happy.jsonl"  # run where the recording is made
IN_TERMINALS = "it runs until Ctrl-C, and is started by many tests"
SUITE = "it is run by `make test` as a whole"
LOCALIZATION = "tests/acromovi/test_localize.py, with a map of its own"
FORMATION = "tests/apps/formation/test_on_a_team.py, with two robots"
FOLLOWING = "tests/apps/robot_following/test_on_a_team.py, with two robots"
OPTICAL_FLOW = "tests/apps/optical_flow/test_on_a_team.py"
CALIBRATION = "tests/acromovi/test_camera.py, on drawn chessboards"
DOCKING = "tests/apps/docking/test_on_a_team.py"
CONSOLE = "tests/apps/console, on any free port"
FETCH = "tests/apps/fetch/test_on_a_team.py"
FETCH_BY_ARM = "tests/apps/fetch/test_arm_on_a_team.py"
SURVEILLANCE = "tests/apps/surveillance"
WORLD = "tests/acromovi/test_world.py, with an emulator that no other test finds"
RECORDING = "tests/acromovi/test_recording_page.py"
EXPLORING = "tests/acromovi/mapping/test_exploring_command.py, with agents that play the robot"
MAPS = "tests/acromovi/mapping/test_map_command.py and tests/agents/components/mapping"
ELSEWHERE = {
    "acromovi map build happy --explore": EXPLORING,
    "acromovi map build happy doc --explore": EXPLORING,
    "acromovi map build happy --extend lab.map --at 2.5 1.0 1.57 --save lab.map": MAPS,
    "acromovi map save happy lab.map": MAPS,
    "acromovi map show lab.map lab.png": MAPS,
    "acromovi map merge happy.map doc.map building.map --picture building.png": MAPS,
    "p2os-emu --robot powerbot --world hall:7": "tests/p2os_emu/world/floors",
    "acromovi try gripper": "tests/acromovi/test_scenes.py",
    "acromovi up acromovi": "tests/acromovi/team/test_team_of_seven.py",
    "acromovi up acromovi --apps .": "the fixture of tests/test_pages_on_a_team.py",
    "acromovi up dwarfs.toml --bus secure:keys": "tests/acromovi/team/test_identities.py",
    "acromovi up two-real-five-emulated --check": "tests/acromovi/team/test_gateway_settings.py",
    "acromovi up two-real-five-emulated --only happy --units units": "tests/acromovi/team/test_gateway_settings.py",
    "acromovi world truth": WORLD,
    "acromovi world pose powerbot 8 6 1.57": WORLD,
    "acromovi world fault line-cut@0+3": WORLD,
    "acromovi world fault line-cut:robot=happy,cable=laser": "tests/acromovi/team/test_team_of_seven.py",
    "acromovi world clear": "tests/acromovi/team/test_team_of_seven.py",
    "acromovi world pause": WORLD,
    "acromovi world step 120": WORLD,
    "acromovi world resume": WORLD,
    "acromovi record happy --output drive.mcap --seconds 10": RECORDING,
    "acromovi replay drive.mcap --speed 10 --rename happy=recorded": RECORDING,
    "acromovi plot drive.mcap": RECORDING,
    "acromovi console --replay drive.mcap": "tests/apps/console/in_a_browser/test_a_recording.py",
    "acromovi agent start broker@acromovi agents.services.broker:BrokerAgent --in services": (
        "tests/agents/services/test_broker.py"
    ),
    "acromovi agent clone follow@happy twin@happy --in attic": "tests/acromovi/test_agent_commands.py",
    "acromovi send request sonar@happy --action read": "tests/acromovi/test_send.py",
    "acromovi send inform follow@happy --content '{\"speed\": 0.3}'": "tests/acromovi/test_send.py",
    "python examples/protocols.py": "tests/test_protocols.py",
    "acromovi up house.toml": "tests/acromovi/navigation",
    "acromovi navigate go happy -2 2.4 --wait": "tests/acromovi/navigation",
    "acromovi navigate picture happy way.svg": "tests/acromovi/navigation",
    "acromovi navigate up happy": "tests/acromovi/navigation",
    "acromovi navigate go happy 6 2.5 --wait": "tests/acromovi/navigation",
    "acromovi navigate picture happy now.svg": "tests/acromovi/navigation",
    "acromovi navigate wiring happy wiring.svg": "tests/acromovi/navigation",
    "acromovi localize happy --map office.map": LOCALIZATION,
    "acromovi localize happy --map office.map --unknown": LOCALIZATION,
    "acromovi localize happy --map office.yaml --pose 2.5 6.1 1.57": LOCALIZATION,
    "acromovi localize happy --state": LOCALIZATION,
    "acromovi localize happy --stop": LOCALIZATION,
    "acromovi navigate go happy 6 2.5 --map --heading 1.57": LOCALIZATION,
    'acromovi navigate go happy "Lab 2" --wait': LOCALIZATION,
    "acromovi ask localization@happy set_pose x=2.5 y=6.1 heading=1.57": "tests/agents/components",
    "python -m benchmarks localization": "it is a benchmark, which takes minutes",
    "acromovi ask colours@happy serve_acts port=5001": "tests/agents/components/vision, with other ports",
    "acromovi run formation leader=happy followers=doc,grumpy shape=triangle starts=my-team.toml": FORMATION,
    "acromovi promote formation leader=happy followers=doc,grumpy starts=my-team.toml": FORMATION,
    "acromovi run formation leader=happy followers=doc,grumpy poses=sight": (
        "tests/apps/formation/test_sight_on_a_team.py, with two robots"
    ),
    "acromovi ask formation@apps shape shape=line": FORMATION,
    "acromovi ask formation@apps status": FORMATION,
    "acromovi camera calibrate doc --board 9x6 --into my-team.toml doc": CALIBRATION,
    "acromovi camera calibrate views/*.png --board 9x6 --into my-team.toml doc": CALIBRATION,
    "acromovi remote-vision happy": "tests/apps/remote_vision, on any free port",
    "acromovi up acromovi --console": "tests/apps/console, with two robots",
    "acromovi console": CONSOLE,
    "acromovi console --password": "tests/acromovi/test_console.py, with another file",
    "acromovi console --host 0.0.0.0": CONSOLE,
    "acromovi console --host 0.0.0.0 --certificate keys/router.lab": (
        "tests/apps/console/in_a_browser/test_certificates.py, on loopback"
    ),
    "acromovi keys make --role router --name lab --host lab.example.org": "tests/acromovi/test_keys.py",
    "acromovi keys export operator.anna": "tests/acromovi/test_keys.py",
    "acromovi run robot_following robot=happy": FOLLOWING,
    "acromovi run robot_following robots=happy,sleepy": FOLLOWING,
    "acromovi run robot_following robot=happy colours=trained": FOLLOWING,
    "acromovi promote robot_following robot=happy": FOLLOWING,
    "acromovi ask robot_following@apps status": FOLLOWING,
    "acromovi teleop doc": "tests/acromovi/test_teleop.py",
    "acromovi up lab.toml": OPTICAL_FLOW,
    "acromovi run optical_flow robot=bart": OPTICAL_FLOW,
    "acromovi run optical_flow robot=bart page=8080": "tests/apps/optical_flow/test_in_a_browser.py, on any free port",
    "acromovi promote optical_flow robot=bart": OPTICAL_FLOW,
    "acromovi ask optical_flow@apps status": OPTICAL_FLOW,
    "acromovi run fetch robot=bart colour=red place=[0.5,0.6]": FETCH,
    "acromovi promote fetch robot=bart colour=red place=[0.5,0.6]": FETCH,
    "acromovi ask fetch@apps status": FETCH,
    "acromovi up posts.toml": FETCH_BY_ARM,
    "acromovi run fetch robot=max colour=red place=[1.0,1.5]": FETCH_BY_ARM,
    "acromovi up charge.toml": DOCKING,
    "acromovi run docking robot=max dock=[1.5,0,0]": DOCKING,
    "acromovi localize doc --map office.map --pose 6.0 1.8 1.57": LOCALIZATION,
    "acromovi run surveillance map=office.map": SURVEILLANCE,
    "acromovi run surveillance map=night.map starts=night.toml": SURVEILLANCE,
    "acromovi up night.toml": SURVEILLANCE,
    "acromovi world add p3dx-sh --name stranger --at 3.2 2.3": WORLD,
    "acromovi promote surveillance map=night.map": SURVEILLANCE,
    "acromovi ask surveillance@apps status": SURVEILLANCE,
    "acromovi ask surveillance@apps report folder=so-far": SURVEILLANCE,
    "python -m benchmarks surveillance": "it is a benchmark, which takes minutes",
    "acromovi teleop happy": "tests/acromovi/test_teleop.py",
    "acromovi container --services acromovi": IN_TERMINALS,
    "acromovi wire /dev/ttyUSB0 --listen /tmp/tapped": "tests/acromovi/test_wire.py",
    "p2os-gateway /dev/ttyS0 --name doc --laser /dev/ttyS1 /dev/ttyS2 --name max --config max.toml --wait": (
        "tests/gateway/test_many_robots.py, with other ports"
    ),
    "p2os-gateway /dev/ttyUSB0": IN_TERMINALS,
    "p2os-gateway socket://localhost:8101 --name happy": "tests/gateway, with tests/gateway/simulator_peer.py",
    "pytest tests/agents/faults": SUITE,
    "pytest pty_tests": SUITE,
    "pytest pty_tests --port /dev/ttyUSB0": "it is for a real robot",
    "pytest pty_tests --port /dev/ttyUSB0 --report report.json": "it is for a real robot",
    "python -m benchmarks stop_proof": "it is a benchmark, which takes minutes",
    "python -m benchmarks crowd headless": "it is a benchmark, which takes minutes",
    "python -m benchmarks optical_flow fetch --seeds 100-103 --drive-minutes 2 --jobs 1": "it is a benchmark, too",
    "python -m benchmarks --peer 127.0.0.1:8101 --peer-pid 4711": "tests/benchmarks/test_compare.py",
}
"""Commands that no test of the pages runs, and why: another test does, or nothing but people can."""
PYTHON_ELSEWHERE = {"bus": 1, "components": 1, "emulator": 2, "recording": 1, "testing": 2, "vision": 2}
"""Programs on pages that other tests run: tests/test_readme.py, tests/agents/components/test_results_together.py,
tests/vision/test_operations.py, tests/acromovi/test_calibration_of_an_emulated_camera.py,
tests/test_pages_on_the_emulator.py, tests/acromovi/test_recording_page.py."""


def page(name: str) -> str:
    """Return the text of a page."""
    return (ROOT / "docs" / f"{name}.md").read_text(encoding="utf-8")


def command_lines(name: str, program: str) -> list[str]:
    """Return the commands in the shell blocks of a page, without prompts and comments."""
    lines = [line for language, text in blocks(page(name)) if not language for line in text.splitlines()]
    bare = [re.sub(r"^(\$ )?(\.venv/bin/)?", "", line.partition(" #")[0]).strip() for line in lines]
    return [line for line in bare if re.match(rf"{program} (?!\w+: )", line)]


def to_run(name: str, program: str) -> list[str]:
    """Return the commands of a page that a test of the pages runs."""
    return [line for line in command_lines(name, program) if line not in ELSEWHERE]


def files(name: str, language: str) -> list[str]:
    """Return the blocks of a page in a language."""
    return [text for each, text in blocks(page(name)) if each == language]

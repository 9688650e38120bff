"""Measure the figures of the project: `python -m benchmarks`."""

import argparse
import importlib
import os
import sys
import uuid
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from benchmarks.drives import add_options
from benchmarks.figures import Figure, as_text, write_json, write_picture
from benchmarks.noise import NoiseMeter
from configs import ConfigError
from configs.defaults import VARIABLE
from p2os_emu.world import WorldError

GROUPS = {
    "codec": "time to decode and encode one SIP",
    "determinism": "the same seed and commands give the same bytes",
    "accuracy": "how exactly moves, turns and stops end",
    "cadence": "how evenly SIPs come on a pty",
    "emulator": "processor time of one robot and of twenty, and readiness",
    "crowd": "processor time of driving robots over TCP in office, in the machine's own unit, and memory",
    "headless": "how many times faster than real time the emulator is, with 1 to 50 robots",
    "laser": "scans per second by the line's rate, and processor time of robots with lasers",
    "camera": "SIP cadence and processor time while somebody looks through a robot's camera",
    "latency": "from the port to the bus and from the bus to the port",
    "gateway": "processor time and memory of the gateway",
    "stop_proof": "time and distance until the wheels stand, whatever dies; writes stop-proof.md",
    "radio": "a million packets over a damaged radio modem: used, rejected, counted",
    "fuzz": "ten million generated frames into every parser, a million payloads from the bus: no crash",
    "agents": "requests, informs, crowds of agents, and searches of the directory",
    "team": "start-up, processor time and memory of a team of seven robots, idle and driving, by kind of process",
    "recorder": "processor time and losses of recording the team with two cameras, and what kill -9 loses",
    "supervision": "what happens when agents' processes die, and what an agent adds to a stream",
    "fuser": "what fusing a thousand commands a second costs, and whether an old one is ever used",
    "navigation_latency": "from a scan or sonar message to the fused command, all components in processes of their own",
    "navigation_idle": "what the navigation costs after a mission, and how soon the next one wakes it",
    "doors": "doors found in generated laser scans, and the time that one scan takes",
    "missions": "three hundred missions of the indoor navigation in lockstep; writes missions.md and pictures",
    "map_navigation": "missions on a map: static, changed, with people and a second robot; writes table and picture",
    "map_team": "seven robots with goals in one building, in lockstep; writes map-team.json and a picture",
    "mapping": "maps of laser scans against the truth, in lockstep; writes mapping.md and pictures",
    "exploration": "exploration of floors by one robot and by two, in lockstep; writes exploration.md",
    "surveillance": "patrols of generated floors in virtual time; writes surveillance.md and pictures",
    "formation": "formations of three to five robots in lockstep; writes formation.md and pictures",
    "following": "robots that follow each other by sight, rendered in lockstep; writes following.md and pictures",
    "optical_flow": "wandering by optical flow in textured rooms in lockstep; writes optical-flow.md and pictures",
    "fetch": "fetching objects with the gripper, rendered in lockstep; writes fetch.md and a picture",
    "docking": "docking from fifty starts in lockstep; writes docking.md",
    "localization": "localization on true maps by laser and sonar, in lockstep; writes localization.md and pictures",
    "vision": "colours, target and time to contact in drawn images, and the delay of the vision agents",
    "remote_vision": "age of an image when the browser has drawn it: over loopback, and with delay and loss",
    "console": "processor time and memory of the web console, age of its map, and how soon a joystick reaches the line",
    "console_hour": "memory of console, browser and team while a map is open for an hour; writes console-hour.csv",
    "flood": "how soon an e-stop is obeyed while other programs flood the gateway",
    "recovery": "how soon a gateway is received again after it or its subscriber was frozen",
    "soak": "memory, threads and descriptors of a team while sessions join and leave; writes soak.csv",
    "connect": "time to connect from any state, and to come back after the cable was pulled",
}
COMPARE = "compare"
PEER_GROUPS = {COMPARE: "the emulator beside another simulator of the protocol (--peer), in turns"}


def main(argv: Sequence[str] | None = None) -> int:
    """Run the groups asked for, print each figure and how noisy the machine was, write JSON and a picture."""
    everything = GROUPS | PEER_GROUPS
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks",
        description="Measure the figures of the project.",
        epilog="groups:\n"
        + "\n".join(f"  {name:<18} {what}" for name, what in everything.items())
        + "\n\nexample: python -m benchmarks codec latency --out /tmp/bench",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("group", nargs="*", choices=[*everything, []], help="what to measure (default: all)")
    parser.add_argument("--out", type=Path, default=Path("bench"), help="folder for figures.json and figures.png")
    parser.add_argument("--minutes", type=float, default=10.0, help="length of the cadence run (default: 10)")
    parser.add_argument("--soak-minutes", type=float, default=2.0, help="length of the soak run (default: 2)")
    parser.add_argument("--soak-pace", type=float, default=33.0, help="its sessions per minute (default: 33)")
    parser.add_argument(
        "--console-minutes", type=float, default=60.0, help="length of the run of console_hour (default: 60)"
    )
    parser.add_argument(
        "--first-seed", type=int, metavar="SEED", help="other floors for map_navigation and map_team, from this seed on"
    )
    parser.add_argument(
        "--team-goals", type=int, default=70, help="goals of seven robots in each building of map_team (default: 70)"
    )
    parser.add_argument(
        "--goals", type=int, default=10, help="goals of each condition of map_navigation (default: 10; all: 200)"
    )
    parser.add_argument(
        "--resume", action="store_true", help="go on with the run of map_navigation that was interrupted, of this --out"
    )
    add_options(parser)
    parser.add_argument("--map", metavar="FILE", action="append", help="build the map of this world too; repeatable")
    parser.add_argument("--peer", metavar="HOST:PORT", help="compare the emulator with a simulator on this TCP port")
    parser.add_argument(
        "--peer-pid", type=int, metavar="PID", help="its process on this machine, to compare processor time"
    )
    parser.add_argument("--rounds", type=int, default=5, help="turns of each in the comparison (default: 5)")
    options = parser.parse_args(argv)
    if options.peer is None and (COMPARE in options.group or options.peer_pid is not None):
        parser.error(f"{COMPARE} and --peer-pid need --peer HOST:PORT")
    groups = options.group or (PEER_GROUPS if options.peer else GROUPS)
    os.environ.setdefault(VARIABLE, f"local:bench-{uuid.uuid4().hex[:12]}")  # nobody else's messages are measured
    figures: list[Figure] = []
    for group in groups:
        print(f"-- {group}: {everything[group]}", flush=True)
        meter = NoiseMeter([options.peer_pid] if options.peer_pid else [])
        try:
            found = importlib.import_module(f"benchmarks.{group}").measure(options)
        except (ConfigError, WorldError) as err:
            parser.exit(2, f"{parser.prog}: {err}\n")
        noise = meter.read()
        for figure in (replace(each, doubt=noise.doubt) for each in found):
            figures.append(figure)
            print(as_text(figure), flush=True)
        print(f"     machine: {noise}", flush=True)
    options.out.mkdir(parents=True, exist_ok=True)
    write_json(figures, options.out / "figures.json")
    write_picture(figures, options.out / "figures.png")
    missed = sum(not figure.is_reached for figure in figures)
    doubtful = sum(bool(figure.doubt) for figure in figures)
    print(f"{len(figures)} figures, {missed} missed, {doubtful} not trustworthy")
    print(f"see {options.out}/figures.json and {options.out}/figures.png")
    return 0


if __name__ == "__main__":
    sys.exit(main())

"""Measure the figures of the project: `python -m benchmarks`."""

import argparse
import importlib
import os
import sys
import uuid
from collections.abc import Sequence
from pathlib import Path

from benchmarks.figures import Figure, as_text, write_json, write_picture
from configs.defaults import VARIABLE

GROUPS = {
    "codec": "time to decode and encode one SIP",
    "determinism": "the same seed and commands give the same bytes",
    "accuracy": "how exactly moves, turns and stops end",
    "cadence": "how evenly SIPs come on a pty",
    "emulator": "processor time of one robot and of twenty, and readiness",
    "laser": "scans per second by the line's rate, and processor time of robots with lasers",
    "camera": "SIP cadence and processor time while somebody looks through a robot's camera",
    "latency": "from the port to the bus and from the bus to the port",
    "gateway": "processor time and memory of the gateway",
    "stop_proof": "time and distance until the wheels stand, whatever dies; writes stop-proof.md",
    "radio": "a million packets over a damaged radio modem: used, rejected, counted",
    "fuzz": "ten million generated frames into every parser, a million payloads from the bus: no crash",
    "agents": "requests, informs, crowds of agents, and searches of the directory",
    "team": "start-up, processor time and memory of a team of seven robots, idle and driving, by kind of process",
    "supervision": "what happens when agents' processes die, and what an agent adds to a stream",
    "fuser": "what fusing a thousand commands a second costs, and whether an old one is ever used",
    "navigation_latency": "from a scan or sonar message to the fused command, all components in processes of their own",
    "doors": "doors found in generated laser scans, and the time that one scan takes",
    "missions": "three hundred missions of the indoor navigation in lockstep; writes missions.md and pictures",
    "flood": "how soon an e-stop is obeyed while other programs flood the gateway",
    "recovery": "how soon a gateway is received again after it or its subscriber was frozen",
    "soak": "memory, threads and descriptors of a team while sessions join and leave; writes soak.csv",
    "connect": "time to connect from any state, and to come back after the cable was pulled",
}


def main(argv: Sequence[str] | None = None) -> int:
    """Run the groups asked for, print each figure, write JSON and a picture."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks",
        description="Measure the figures of the project.",
        epilog="groups:\n"
        + "\n".join(f"  {name:<18} {what}" for name, what in GROUPS.items())
        + "\n\nexample: python -m benchmarks codec latency --out /tmp/bench",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("group", nargs="*", choices=[*GROUPS, []], help="what to measure (default: all)")
    parser.add_argument("--out", type=Path, default=Path("bench"), help="folder for figures.json and figures.png")
    parser.add_argument("--minutes", type=float, default=10.0, help="length of the cadence run (default: 10)")
    parser.add_argument("--soak-minutes", type=float, default=2.0, help="length of the soak run (default: 2)")
    parser.add_argument("--soak-pace", type=float, default=33.0, help="its sessions per minute (default: 33)")
    options = parser.parse_args(argv)
    os.environ.setdefault(VARIABLE, f"local:bench-{uuid.uuid4().hex[:12]}")  # nobody else's messages are measured
    figures: list[Figure] = []
    for group in options.group or GROUPS:
        print(f"-- {group}: {GROUPS[group]}", flush=True)
        for figure in importlib.import_module(f"benchmarks.{group}").measure(options):
            figures.append(figure)
            print(as_text(figure), flush=True)
    options.out.mkdir(parents=True, exist_ok=True)
    write_json(figures, options.out / "figures.json")
    write_picture(figures, options.out / "figures.png")
    missed = sum(not figure.is_reached for figure in figures)
    print(f"{len(figures)} figures, {missed} missed; see {options.out}/figures.json and {options.out}/figures.png")
    return 0


if __name__ == "__main__":
    sys.exit(main())

"""`acromovi try`: show a feature with an emulated robot."""

import argparse
import sys
import uuid

from acromovi.children import ChildFailed
from acromovi.scenes.stage import SceneFailed, set_stage
from acromovi.subcommand import Subcommand
from bus import BusError
from configs.extras import require

EPILOG = """\
examples:
  acromovi try                 what there is to try
  acromovi try gripper         a Pioneer picks up a box, carries it and puts it down
  acromovi try laser camera    one after the other

Each scene starts an emulated robot and its gateway, shows both command lines, and ends by itself within half a minute.

Exit codes: 0 all was seen, 1 something was not (the reason is on stderr), 2 there is no such scene.
"""


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("scene", metavar="SCENE", nargs="*", help="scene to play; without one all scenes are listed")


def _run(arguments: argparse.Namespace) -> int:
    """Play the scenes asked for."""
    from acromovi.scenes.all_scenes import SCENES

    if not arguments.scene:
        width = max(map(len, SCENES))
        print("\n".join(f"{scene.name:{width}}  {scene.shows}" for scene in SCENES.values()))
        return 0
    for name in arguments.scene:
        if name not in SCENES:
            print(f"acromovi try: there is no {name!r}; choose one of {', '.join(SCENES)}", file=sys.stderr)
            return 2
    require("a scene", "emu")
    return max(_play(name) for name in arguments.scene)


def _play(name: str) -> int:
    from acromovi.scenes.all_scenes import SCENES

    scene = SCENES[name]
    print(f"-- {scene.name}: {scene.shows}", flush=True)
    robot = f"{name}-{uuid.uuid4().hex[:6]}"[:19]
    try:
        with set_stage(scene, robot, lambda sentence: print(sentence, flush=True)) as stage:
            scene.play(stage)
    except (SceneFailed, ChildFailed, BusError) as error:
        print(f"acromovi try {name}: {error}", file=sys.stderr)
        return 1
    return 0


COMMAND = Subcommand(EPILOG, _add_arguments, _run)

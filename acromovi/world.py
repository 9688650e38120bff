"""`acromovi world`: look at and change the world of an emulator through its control socket."""

import argparse
import json
import math
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import configs
from acromovi.options import count
from acromovi.subcommand import Subcommand

FOLDERS = ("p2os-emu-", "acromovi-")  # of an emulator alone, and of one in a team
STEPPING_TIME = 600.0  # s that ten minutes of emulated time may take
EPILOG = """\
examples:
  acromovi world truth                       where everything really is
  acromovi world pose happy 14 6.1 1.57      put a robot there: m, m, rad
  acromovi world door entrance shut
  acromovi world fault line-cut:robot=happy,cable=laser@0+3
  acromovi world clear                       end all faults
  acromovi world pause
  acromovi world step 120                    one second of paused time
  acromovi world resume
  acromovi world speed 2
  acromovi world add p3dx-sh --name anna --fit laser --at 14 6.1
  acromovi world remove anna
  acromovi world list                        the emulators that run here

The emulator is found by itself, also that of a team. If several run here, it is the one that has the robot; otherwise
name the path of its control socket with --control. With --json a command prints the reply of the emulator, one object
on one line. p2os-emu --list-faults lists the faults.

Exit codes: 0 done, 1 refused or no emulator (the reason is on stderr), 2 wrong usage.
"""

Request = dict[str, Any]
Reply = Mapping[str, Any]


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    common = argparse.ArgumentParser(add_help=False, allow_abbrev=False)
    common.add_argument("--control", type=Path, metavar="PATH", help="set the control socket [found by itself]")
    common.add_argument("--json", action="store_true", help="print the reply as one line of JSON")
    actions = parser.add_subparsers(dest="action", metavar="ACTION", required=True)

    def add(name: str, what: str, request: Callable[[argparse.Namespace], Request] | None = None) -> Any:
        action = actions.add_parser(name, help=what, description=f"{what}.", parents=[common], allow_abbrev=False)
        action.set_defaults(request=request or (lambda given: {"do": name}))
        return action

    truth = add("truth", "print where robots, people, doors and objects really are", _robot_request("truth"))
    truth.add_argument("robot", metavar="ROBOT", nargs="?", help="only this robot")
    pose = add("pose", "put a robot somewhere, or print where it is", _pose_request)
    pose.add_argument("robot", metavar="ROBOT", help="name of the robot")
    pose.add_argument("place", metavar="X Y [HEADING]", nargs="*", type=_number, help="place in m, heading in rad")
    door = add("door", "open or shut a door", lambda given: _door_request(given.name, given.state))
    door.add_argument("name", metavar="DOOR", help="name of the door")
    door.add_argument("state", choices=("open", "shut"), help="what to do with it")
    add("doors", "list the doors", lambda given: {"do": "truth"})
    add("people", "list the people", lambda given: {"do": "truth"})
    add("objects", "list the objects that can be moved", lambda given: {"do": "truth"})
    fault = add("fault", "apply a fault", lambda given: {"do": "fault", "fault": given.fault})
    fault.add_argument("fault", metavar="FAULT", help="name, parameters and times: line-cut:robot=happy@0+3")
    add("faults", "list the faults that are applied, and those that can be")
    clear = add("clear", "end one fault, or all", _clear_request)
    clear.add_argument("number", metavar="NUMBER", nargs="?", type=int, help="number of the fault [all]")
    add("pause", "stop the time", lambda given: {"do": "pause", "on": True})
    add("resume", "let time go on", lambda given: {"do": "pause", "on": False})
    step = add("step", "let paused time go on by steps of 1/120 s", lambda given: {"do": "step", "n": given.n})
    step.add_argument("n", metavar="N", nargs="?", type=count, default=1, help="how many [1]")
    speed = add("speed", "set or print the emulated seconds per second", _speed_request)
    speed.add_argument("factor", metavar="FACTOR", nargs="?", type=_number, help="the new speed")
    new = add("add", "add a robot", _add_request)
    new.add_argument("model", metavar="MODEL", help="a model of configs/robots, or a file")
    new.add_argument("--name", help="set its name [its model]")
    new.add_argument("--fit", metavar="PARTS", help="set its accessories: gripper,laser")
    new.add_argument(
        "--at", metavar=("X", "Y"), nargs=2, type=_number, help="set its place, m [a free place of the world]"
    )
    new.add_argument("--heading", metavar="RAD", type=_number, help="set its heading, rad; needs --at")
    remove = add("remove", "remove a robot", _robot_request("remove"))
    remove.add_argument("robot", metavar="ROBOT", help="name of the robot")
    reset = add("reset", "restart the microcontroller of a robot, or of all", _robot_request("reset"))
    reset.add_argument("robot", metavar="ROBOT", nargs="?", help="only this robot")
    stick = add("joystick", "move the joystick of a robot", _joystick_request)
    stick.add_argument("robot", metavar="ROBOT", help="name of the robot")
    stick.add_argument("x", metavar="X", type=_number, help="to the side, -1 to 1")
    stick.add_argument("y", metavar="Y", type=_number, help="forward, -1 to 1")
    stick.add_argument("--throttle", metavar="T", type=_number, help="set the throttle, 0 to 1")
    stick.add_argument("--button", action="append", choices=("1", "2"), default=[], help="hold a button; repeatable")
    add("quit", "end the emulator")
    add("list", "list the emulators that run here")


def _number(text: str) -> float:
    """A finite number."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"{text} is not a finite number")
    return value


def _robot_request(do: str) -> Callable[[argparse.Namespace], Request]:
    return lambda given: {"do": do} | ({"robot": given.robot} if given.robot else {})


def _pose_request(given: argparse.Namespace) -> Request:
    if len(given.place) not in (0, 2, 3):
        raise _WrongUsage("a place is X Y or X Y HEADING")
    return {"do": "pose", "robot": given.robot, **dict(zip(("x", "y", "heading"), given.place, strict=False))}


def _door_request(name: str, state: str) -> Request:
    return {"do": "door", "name": name, "open": state == "open"}


def _clear_request(given: argparse.Namespace) -> Request:
    return {"do": "clear"} | ({} if given.number is None else {"number": given.number})


def _speed_request(given: argparse.Namespace) -> Request:
    return {"do": "speed"} | ({} if given.factor is None else {"factor": given.factor})


def _model(text: str) -> str:
    """Return a model as the emulator finds it, whose working directory may be another.

    Raises:
        ConfigError: There is no such model.
    """
    return str(Path(text).resolve()) if configs.find("robots", text) == Path(text) else text


def _add_request(given: argparse.Namespace) -> Request:
    if given.heading is not None and given.at is None:
        raise _WrongUsage("--heading needs --at")
    place = dict(zip(("x", "y"), given.at or (), strict=False))
    chosen = {"name": given.name, "fit": given.fit, "heading": given.heading, **place}
    return {
        "do": "add",
        "model": _model(given.model),
        **{key: value for key, value in chosen.items() if value is not None},
    }


def _joystick_request(given: argparse.Namespace) -> Request:
    held = {f"button{number}": number in given.button for number in ("1", "2")}
    throttle = {} if given.throttle is None else {"throttle": given.throttle}
    return {"do": "joystick", "robot": given.robot, "x": given.x, "y": given.y, **held, **throttle}


class _WrongUsage(Exception):
    """The words of the command line do not fit together; the message says why."""


class _NoEmulator(Exception):
    """There is no emulator, or it is not clear which one is meant; the message says what to do."""


def _run(arguments: argparse.Namespace) -> int:
    """Send one request, and print the reply."""
    from p2os_emu.control_client import ANSWER_TIME, ControlRefused, ask_emulator

    path = arguments.control
    try:
        if arguments.action == "list":
            return _list(arguments.json)
        request = arguments.request(arguments)
        path = path or _found(request.get("robot") if request["do"] != "add" else None)
        reply = ask_emulator(path, request, STEPPING_TIME if request["do"] == "step" else ANSWER_TIME)
    except _WrongUsage as err:
        print(f"acromovi world: {err}", file=sys.stderr)
        return 2
    except (_NoEmulator, ControlRefused, configs.ConfigError) as err:
        print(f"acromovi world: {err}", file=sys.stderr)
        return 1
    except (OSError, ValueError) as err:
        why = err.strerror if isinstance(err, OSError) and err.strerror else str(err)
        print(f"acromovi world: {path} does not answer as a control socket ({why})", file=sys.stderr)
        return 1
    print(json.dumps(reply) if arguments.json else "\n".join(_SHOWN[arguments.action](reply)))
    return 0


def _running() -> list[tuple[Path, Reply]]:
    """Return the emulators that run here and answer: their control sockets, and the truth."""
    from p2os_emu.control_client import ControlRefused, ask_emulator, control_sockets

    found: list[tuple[Path, Reply]] = []
    for path in control_sockets(FOLDERS):
        try:
            found.append((path, ask_emulator(path, {"do": "truth"})))
        except (OSError, ValueError, ControlRefused):
            continue  # one that was killed or is frozen
    return found


def _found(robot: str | None) -> Path:
    """Return the control socket of the emulator that is meant.

    Raises:
        _NoEmulator: None runs here, or several of which none is meant.
    """
    running = _running()
    meant = [path for path, truth in running if robot in truth["robots"]] if robot and len(running) > 1 else []
    if len(running) == 1 or len(meant) == 1:
        return (meant or [running[0][0]])[0]
    if not running:
        raise _NoEmulator(
            "no emulator runs here; start one with p2os-emu or acromovi up, or name the control socket with --control"
        )
    shown = "; ".join(f"--control {path} ({', '.join(truth['robots']) or 'no robot'})" for path, truth in running)
    raise _NoEmulator(f"{len(running)} emulators run here; choose one: {shown}")


def _list(as_json: bool) -> int:
    rows = [
        {"control": str(path), "robots": list(truth["robots"]), "time": truth["time"], "paused": truth["paused"]}
        for path, truth in _running()
    ]
    if as_json:
        print(json.dumps({"emulators": rows}))
        return 0
    for row in rows:
        state = ", paused" if row["paused"] else ""
        print(f"{row['control']}  {', '.join(row['robots']) or 'no robot'}  {row['time']:.1f} s{state}")
    if not rows:
        print("none")
    return 0


# Replies for people, line by line.


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    widths = [max(len(row[at]) for row in (head, *rows)) for at in range(len(head))]
    return [
        "  ".join(f"{cell:<{width}}" for cell, width in zip(row, widths, strict=True)).rstrip() for row in (head, *rows)
    ]


def _place(row: Reply) -> list[str]:
    return [f"{row['x']:.2f}", f"{row['y']:.2f}", f"{row['heading']:.2f}"]


def _show_truth(reply: Reply) -> list[str]:
    rows = [
        [
            name,
            row["model"],
            *_place(row),
            f"{row['linear']:.2f}",
            f"{row['angular']:.2f}",
            "on" if row["motors_enabled"] else "off",
            "yes" if row["connected"] else "no",
        ]
        for name, row in reply["robots"].items()
    ]
    head = ["robot", "model", "x, m", "y, m", "heading, rad", "m/s", "rad/s", "motors", "connected"]
    lines = _table(head, rows) if rows else ["no robot"]
    for what, show in (("people", _show_people), ("doors", _show_doors), ("objects", _show_objects)):
        if reply[what]:
            lines += ["", *show(reply)]
    return [*lines, "", _show_time(reply)]


def _show_people(reply: Reply) -> list[str]:
    rows = [[name, *_place(row), "walks" if row["walks"] else "stands"] for name, row in reply["people"].items()]
    return _table(["person", "x, m", "y, m", "heading, rad", ""], rows) if rows else ["no people in this world"]


def _show_doors(reply: Reply) -> list[str]:
    rows = [[name, f"{row['opening']:.2f}", f"{row['width']:.2f}"] for name, row in reply["doors"].items()]
    return _table(["door", "opening, m", "width, m"], rows) if rows else ["no doors in this world"]


def _show_objects(reply: Reply) -> list[str]:
    rows = [[name, *(f"{value:.2f}" for value in place)] for name, place in reply["objects"].items()]
    head = ["object", "x, m", "y, m", "height, m", "heading, rad"]
    return _table(head, rows) if rows else ["no objects in this world"]


def _show_time(reply: Reply) -> str:
    state = "paused" if reply["paused"] else f"speed {reply['speed']:g}"
    lost = f", {reply['lost']:.1f} s lost under load" if reply["lost"] else ""
    time = f"time {reply['time']:.2f} s, " if "time" in reply else ""
    return f"{time}{state}{lost}"


def _show_fault(fault: Reply) -> list[str]:
    end = "for ever" if fault["end"] is None else f"to {fault['end']:.1f} s"
    state = "active" if fault["active"] else "not active"
    return [str(fault["number"]), str(fault["fault"]), f"{fault['start']:.1f} s", end, state]


def _show_faults(reply: Reply) -> list[str]:
    head = ["number", "fault", "from", "to", ""]
    lines = (
        _table(head, [_show_fault(each) for each in reply["faults"]]) if reply["faults"] else ["no fault is applied"]
    )
    known = [[name, row["meaning"]] for name, row in reply["known"].items() if row["robots"]]
    return [*lines, "", *_table(["can be applied", ""], known)]


_SHOWN: Mapping[str, Callable[[Reply], list[str]]] = {
    "truth": _show_truth,
    "pose": lambda reply: [f"{reply['robot']} is at {reply['x']:.2f}, {reply['y']:.2f} m, {reply['heading']:.2f} rad"],
    "door": lambda reply: [f"{reply['door']} {'opens' if reply['open'] else 'shuts'}"],
    "doors": _show_doors,
    "people": _show_people,
    "objects": _show_objects,
    "fault": lambda reply: _table(["number", "fault", "from", "to", ""], [_show_fault(reply)]),
    "faults": _show_faults,
    "clear": lambda reply: [f"cleared: {', '.join(map(str, reply['cleared'])) or 'none was applied'}"],
    "pause": lambda reply: [_show_time(reply)],
    "resume": lambda reply: [_show_time(reply)],
    "step": lambda reply: [f"time {reply['time']:.2f} s"],
    "speed": lambda reply: [_show_time(reply)],
    "add": lambda reply: [f"added {reply['robot']['name']}, its port is {reply['robot']['port']}"],
    "remove": lambda reply: [f"removed {reply['removed']}"],
    "reset": lambda reply: [f"restarted {', '.join(reply['reset'])}"],
    "joystick": lambda reply: [f"the joystick of {reply['robot']} is at {reply['x']:.2f}, {reply['y']:.2f}"],
    "quit": lambda reply: ["the emulator ends"],
}

COMMAND = Subcommand(EPILOG, _add_arguments, _run)

"""`acromovi demo`: an emulated robot, its gateway, a drive in one minute, and a picture of it.

The drive knows only the bus. The control socket of the emulator is asked where the robot really is, for the picture.
"""

import argparse
import json
import math
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from acromovi.children import ChildFailed, EmulatedRobots, emulator, end, gateway
from acromovi.subcommand import Subcommand
from acromovi.team.plan import EMULATED
from apps.waypoints import Follower
from bus import Bus, BusError, Sample, ZenohBus, keys, messages
from configs.extras import missing, needs, require
from geometry import Polygon, Pose2D

if TYPE_CHECKING:
    from p2os_emu.world import WorldSpec

EPILOG = """\
example:
  acromovi demo --out /tmp/demo

Exit codes: 0 the whole route was driven, 1 it was not (the reason is on stderr), 130 stopped by Ctrl-C.
"""
MODEL = "powerbot"
ROBOT = "powerbot"
WORLD = "office"
ROUTE = "round"
TRUE_COLOUR = "#1f6f4a"
BELIEVED_COLOUR = "#c2571a"
PERIOD_S = 0.1
CONNECT_TIMEOUT_S = 10.0
DRIVE_TIMEOUT_S = 90.0


@dataclass
class _StreamCounts:
    """The robot's messages on the bus, and their number."""

    pose: Pose2D | None = None
    speed: float = 0.0
    voltage: float = math.nan
    nearest: float = math.inf
    ranges: dict[str, float] = field(default_factory=dict)
    odometry_count: int = 0
    sonar_count: int = 0

    def on_odometry(self, sample: Sample) -> None:
        """Take a pose."""
        message = messages.decode(keys.ODOM.type_name, sample.payload)
        position = message.pose.pose.position
        self.pose = Pose2D(position.x, position.y, messages.heading(message.pose.pose.orientation))
        self.speed = message.twist.twist.linear.x
        self.odometry_count += 1

    def on_sonar(self, sample: Sample) -> None:
        """Take fresh ranges."""
        for reading in messages.decode(keys.SONAR.type_name, sample.payload).ranges:
            self.ranges[reading.header.frame_id] = reading.range
            self.sonar_count += 1
        self.nearest = min(self.ranges.values(), default=math.inf)

    def on_battery(self, sample: Sample) -> None:
        """Take the voltage."""
        self.voltage = messages.decode(keys.BATTERY.type_name, sample.payload).voltage


@dataclass
class _Drive:
    """Result of a drive: both paths in the world's frame, and its duration."""

    true_path: list[Pose2D] = field(default_factory=list)
    odometry_path: list[Pose2D] = field(default_factory=list)
    seconds: float = 0.0

    @property
    def length(self) -> float:
        """Length of the true path, m."""
        steps = zip(self.true_path, self.true_path[1:], strict=False)
        return sum(math.hypot(b.x - a.x, b.y - a.y) for a, b in steps)

    @property
    def drift(self) -> float:
        """Distance between true and odometry pose at the end, m."""
        true, believed = self.true_path[-1], self.odometry_path[-1]
        return math.hypot(believed.x - true.x, believed.y - true.y)


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--out", type=Path, default=Path("demo"), help="set the folder for the picture [demo]")
    parser.add_argument("--seed", type=int, default=1, help="set the seed of the robot's imperfections [1]")


def _run(options: argparse.Namespace) -> int:
    """Run the demo: 0 when the whole route was driven, 1 otherwise."""
    require("the demo", "emu", "plots")
    from p2os_emu.world import load_world

    world = load_world(WORLD)
    try:
        with emulator(
            "--robot", f"{MODEL}:{ROBOT}", "--world", WORLD, "--seed", str(options.seed), "--quiet"
        ) as robots:
            print(f"p2os-emu     an emulated PowerBot on {robots.port}")
            settings = Path(robots.control).with_name("gateway.toml")  # the folder goes with the emulator
            settings.write_text(EMULATED, encoding="utf-8")
            serving = gateway(robots.port, "--quiet", "--config", str(settings))
            with _console(robots), serving, ZenohBus.open() as bus:
                drive, heard = _drive(bus, robots, Follower(world.routes[ROUTE]))
    except (ChildFailed, BusError, TimeoutError) as error:
        print(f"acromovi demo: {error}", file=sys.stderr)
        return 1
    options.out.mkdir(parents=True, exist_ok=True)
    picture = options.out / "drive.png"
    draw_drive(picture, world, drive.true_path, drive.odometry_path)
    print(_summary(drive, heard, picture))
    return 0


@contextmanager
def _console(robots: EmulatedRobots) -> Iterator[None]:
    """Serve the web console until the block ends, and print its address, or how to install it."""
    if missing("console"):
        print(f"console      {needs('the web console', 'console')}")
        yield
        return
    command = [sys.executable, "-m", "acromovi", "console", "--json", "--port", "0"]
    command += ["--map", WORLD, "--control", robots.control]
    with subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            line = process.stdout.readline()
            if line:  # otherwise it has said on stderr why not
                print(f"console      open {json.loads(line)['console']} to see the drive live")
            yield
        finally:
            end(process)


def _drive(bus: Bus, robots: EmulatedRobots, follower: Follower) -> tuple[_Drive, _StreamCounts]:
    heard = _StreamCounts()
    bus.subscribe(keys.ODOM.key(ROBOT), heard.on_odometry)
    bus.subscribe(keys.SONAR.key(ROBOT), heard.on_sonar)
    bus.subscribe(keys.BATTERY.key(ROBOT), heard.on_battery)
    _wait_for_odometry(heard)
    print(f"p2os-gateway messages under {ROBOT}/ on the bus\n")
    start = _truth(robots)
    drive = _Drive()
    began = time.monotonic()
    with _table() as show:
        for now in _every(PERIOD_S, until=began + DRIVE_TIMEOUT_S):
            assert heard.pose is not None
            believed = start.compose(heard.pose)
            drive.true_path.append(_truth(robots))
            drive.odometry_path.append(believed)
            drive.seconds = now - began
            twist = follower.steer(believed)
            bus.put(keys.CMD_VEL.key(ROBOT), messages.twist(twist.linear, twist.angular))
            show(_row(drive, heard, follower))
            if follower.is_done:
                return drive, heard
    raise TimeoutError(f"the robot passed {follower.passed} waypoints in {DRIVE_TIMEOUT_S:.0f} s and then no more")


def _wait_for_odometry(heard: _StreamCounts) -> None:
    for _ in _every(PERIOD_S / 4, until=time.monotonic() + CONNECT_TIMEOUT_S):
        if heard.pose is not None:
            return
    raise TimeoutError("no odometry came from the gateway; run: acromovi doctor")


def _truth(robots: EmulatedRobots) -> Pose2D:
    truth = robots.ask("truth", robot=ROBOT)
    return Pose2D(truth["x"], truth["y"], truth["heading"])


def _every(period: float, until: float) -> Iterator[float]:
    """Yield the time at each period, s on the steady clock, until a deadline."""
    due = time.monotonic()
    while due < until:
        time.sleep(max(0.0, due - time.monotonic()))
        yield time.monotonic()
        due += period


@contextmanager
def _table() -> Iterator[Callable[[str], None]]:
    """A line that redraws itself in a terminal; elsewhere one line every five seconds."""
    live = sys.stdout.isatty()
    print(
        f"{'time':>6} {'x':>7} {'y':>7} {'head':>6} {'speed':>6} {'nearest':>8} {'battery':>8} {'SIPs':>5}  waypoints"
    )
    shown = [-math.inf]

    def show(row: str) -> None:
        now = time.monotonic()
        if now - shown[0] >= (0.2 if live else 5.0):
            shown[0] = now
            print(f"\r{row}\x1b[K" if live else row, end="" if live else "\n", flush=True)

    yield show
    if live:
        print()


def _row(drive: _Drive, heard: _StreamCounts, follower: Follower) -> str:
    pose = drive.odometry_path[-1]
    return (
        f"{drive.seconds:5.1f}s {pose.x:6.2f}m {pose.y:6.2f}m {math.degrees(pose.heading):5.0f}° {heard.speed:6.2f} "
        f"{heard.nearest:7.2f}m {heard.voltage:7.1f}V {heard.odometry_count:5d}  {follower.passed}"
    )


def _summary(drive: _Drive, heard: _StreamCounts, picture: Path) -> str:
    return (
        f"\ndrove {drive.length:.1f} m in {drive.seconds:.0f} s; heard {heard.odometry_count} poses and "
        f"{heard.sonar_count} sonar ranges; odometry ends {drive.drift:.2f} m from the truth; picture: {picture}\n"
        "\nGo on by hand, each line in a terminal of its own:\n"
        "  .venv/bin/p2os-emu --robot powerbot --pty /tmp/powerbot\n"
        "  .venv/bin/p2os-gateway /tmp/powerbot\n"
        "  .venv/bin/acromovi teleop powerbot"
    )


def draw_drive(path: Path, world: "WorldSpec", true_path: Sequence[Pose2D], odometry_path: Sequence[Pose2D]) -> None:
    """Draw a PNG or SVG, by the ending of `path`.

    Args:
        path: Where to write.
        world: What stands where.
        true_path: Poses in the world, m.
        odometry_path: Likewise, as the robot's odometry has them.
    """
    from matplotlib.figure import Figure  # slow to import

    page = Figure(figsize=(11, 7.5), layout="constrained")
    axes = page.subplots()
    _fill(axes, (block.footprint for block in world.walls), "#3d4248", "walls")
    _fill(axes, (block.footprint for block in world.furniture), "#b9b2a3", "furniture")
    axes.plot([p.x for p in true_path], [p.y for p in true_path], color=TRUE_COLOUR, linewidth=2.2, label="true path")
    axes.plot(
        [p.x for p in odometry_path],
        [p.y for p in odometry_path],
        color=BELIEVED_COLOUR,
        linewidth=1.4,
        linestyle="--",
        label="odometry",
    )
    for pose, mark, what in ((true_path[0], "o", "start"), (true_path[-1], "s", "end")):
        axes.plot(pose.x, pose.y, mark, color=TRUE_COLOUR, markersize=8, label=what)
    axes.set_aspect("equal")
    axes.set_xlabel("x, m")
    axes.set_ylabel("y, m")
    axes.set_title(f"World '{world.name}': where the robot drove, and where its odometry has it", loc="left")
    axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
    axes.spines[["top", "right"]].set_visible(False)
    page.savefig(path, dpi=110)


def _fill(axes: object, polygons: Iterable[Polygon], colour: str, label: str) -> None:
    from matplotlib.axes import Axes

    assert isinstance(axes, Axes)
    for number, polygon in enumerate(polygons):
        outline = [x for x, _ in polygon], [y for _, y in polygon]
        axes.fill(*outline, color=colour, linewidth=0, label=label if number == 0 else None)


COMMAND = Subcommand(EPILOG, _add_arguments, _run)

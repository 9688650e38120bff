"""Pictures of a drive: the world, the way a robot took and the way it believes it took."""

from collections.abc import Iterable, Sequence
from pathlib import Path

from geometry import Polygon, Pose2D
from p2os_emu.world import WorldSpec

TRUE_COLOUR = "#1f6f4a"
BELIEVED_COLOUR = "#c2571a"


def draw_drive(path: Path, world: WorldSpec, true_path: Sequence[Pose2D], odometry_path: Sequence[Pose2D]) -> None:
    """Draw a PNG or SVG, by the ending of `path`.

    Args:
        path: Where to write.
        world: What stands where.
        true_path: Poses in the world, m.
        odometry_path: Likewise, as the robot's odometry has them.
    """
    from matplotlib.figure import Figure  # slow to import, and only needed here

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

"""Plots of following: both trajectories, and the gap."""

from collections.abc import Sequence
from pathlib import Path

from apps.pictures import save_picture
from apps.robot_following.record import FollowingRecord
from configs.extras import require
from geometry import Polygon, Pose2D

MOST = 400  # points of a curve
LEADER, FOLLOWERS = "#3d4248", ("#d9730d", "#1f77b4", "#2a9d4a", "#9467bd")


def draw_following(
    file: Path, records: Sequence[FollowingRecord], title: str, gap: float, walls: Sequence[Polygon] = ()
) -> None:
    """Draw records as a file in the format of its ending; each follower has its own frame, beside its leader's path.

    Args:
        file: SVG or PNG.
        records: One for each follower.
        title: Above the trajectories.
        gap: That was to be kept, m.
        walls: Outlines of what stands there, in the frame of the only record, m.
    Raises:
        ExtraMissing: matplotlib is not installed.
        OSError: The file cannot be written.
    """
    require("the picture of robot following", "plots")
    from matplotlib.figure import Figure  # slow to import, and only needed here

    page = Figure(figsize=(4.5 + 4.5 * len(records), 7.5), layout="constrained")
    axes = page.subplots(2, len(records), height_ratios=(2.2, 1), squeeze=False)
    for number, record in enumerate(records):
        plan, gaps = axes[0][number], axes[1][number]
        for wall in walls:
            plan.fill([x for x, _ in wall], [y for _, y in wall], color="#b9b4a8", linewidth=0)
        step = max(1, len(record.times) // MOST)
        colour = FOLLOWERS[number % len(FOLLOWERS)]
        for poses, name, ink in ((record.leader, "leader", LEADER), (record.own, record.follower, colour)):
            plan.plot(*_line(poses[::step]), color=ink, linewidth=1.3, label=name)
        plan.set_title(title if number == 0 else "", loc="left", fontsize=10)
        plan.set_aspect("equal", adjustable="datalim")
        plan.set_xlabel("x, m")
        plan.set_ylabel("y, m")
        plan.legend(frameon=False)
        gaps.axhspan(0.85 * gap, 1.15 * gap, color="#e8e4da", linewidth=0)
        gaps.plot(record.times[::step], record.gaps[::step], color=colour, linewidth=1.0)
        gaps.set_xlabel("time, s")
        gaps.set_ylabel("gap, m (band: 15 %)")
        gaps.set_ylim(bottom=0.0)
        gaps.grid(visible=True, linewidth=0.3)
    save_picture(page, file)


def _line(poses: Sequence[Pose2D | None]) -> tuple[list[float], list[float]]:
    """Return x and y; a gap where nothing was known."""
    known = [(pose.x, pose.y) if pose else (float("nan"), float("nan")) for pose in poses]
    return [x for x, _ in known], [y for _, y in known]

"""The report of a night: a Markdown page with pictures of the floor, of the neglect, and of the alarms."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from apps.pictures import save_picture
from apps.surveillance.algorithms.floor import PatrolFloor
from apps.surveillance.record import NightRecord, most_neglected
from configs.extras import missing, require
from geometry import Point
from maps.building_map import BuildingMap

if TYPE_CHECKING:  # slow to import, and only needed for pictures
    from matplotlib.axes import Axes

PAGE, FLOOR, NEGLECT = "report.md", "floor.png", "neglect.png"
_COLOURS = ("#1f77b4", "#d9730d", "#4a9d2a", "#bd6794", "#9a40c2", "#8a8f98", "#17a2a2")


def write_report(folder: Path, record: NightRecord, map_: BuildingMap | None = None) -> Path:
    """Write the page and its pictures into a folder, which is made if need be; return the page.

    Args:
        folder: Where.
        record: The night.
        map_: Of the building, for the picture of the floor; None where it is not at hand.
    Raises:
        OSError: A file cannot be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    pictures = []
    if not missing("plots"):
        draw_floor(folder / FLOOR, record, map_)
        draw_neglect(folder / NEGLECT, record)
        pictures = [f"![Rooms, paths of the robots, and alarms]({FLOOR})", f"![Neglect of the rooms]({NEGLECT})"]
    page = [
        "# Report of the night",
        "",
        *_head(record),
        "",
        *pictures,
        "",
        "## Rooms",
        "",
        *_rooms(record),
        "",
        "## Alarms",
        "",
        *_alarms(folder, record),
        "",
        "## What happened",
        "",
        *[f"- {each}" for each in record.told],
        "",
    ]
    file = folder / PAGE
    file.write_text("\n".join(page), encoding="utf-8")
    return file


def _head(record: NightRecord) -> list[str]:
    lasted = record.times[-1] if record.times else 0.0
    rooms = record.status.get("rooms", {})
    longest = float(record.status.get("longest", 0.0))
    visits = sum(int(each["visits"]) for each in rooms.values())
    return [
        f"{len(record.status.get('robots', {}))} robots patrolled {len(rooms)} rooms for {lasted / 60.0:.1f} min: "
        f"{visits} visits, longest neglect {longest:.0f} s, {len(record.alarms)} alarms."
    ]


def _rooms(record: NightRecord) -> list[str]:
    rows = [
        "| room | visits | longest neglect, s | neglect at the end, s | robot at the end |",
        "|---|---|---|---|---|",
    ]
    for room in most_neglected(record):
        each = record.status["rooms"][room]
        rows.append(
            f"| {room} | {each['visits']} | {each['longest']:.0f} | {each['neglect']:.0f} | {each['robot'] or 'none'} |"
        )
    return rows


def _alarms(folder: Path, record: NightRecord) -> list[str]:
    if not record.alarms:
        return ["None."]
    rows = ["| alarm | time, s | robot | sensor | place, m | room |", "|---|---|---|---|---|---|"]
    for each in record.alarms.values():
        place = f"({each.place[0]:.1f}, {each.place[1]:.1f})"
        rows.append(f"| {each.number} | {each.time:.0f} | {each.robot} | {each.sensor} | {place} | {each.room} |")
    for number, pictures in sorted(record.pictures.items()):
        for index, data in enumerate(pictures, 1):
            ending = "png" if data.startswith(b"\x89PNG") else "jpg"
            name = f"alarm-{number}-{index}.{ending}"
            (folder / name).write_bytes(data)
            rows += ["", f"![Alarm {number}]({name})"]
    return rows


def draw_floor(file: Path, record: NightRecord, map_: BuildingMap | None = None) -> None:
    """Draw the map with rooms, paths and alarms; SVG or PNG.

    Raises:
        ExtraMissing: matplotlib is not installed.
        OSError: The file cannot be written.
    """
    require("the picture of the floor", "plots")
    from matplotlib.figure import Figure  # slow to import, and only needed here

    page = Figure(figsize=(8.0, 6.0), layout="constrained")
    axes = page.subplots()
    if map_ is not None:
        grid = PatrolFloor(map_, 0.2).grid
        left, low = grid.origin.x, grid.origin.y
        extent = (left, left + grid.width, low, low + grid.height)
        axes.imshow(grid.cells, origin="lower", extent=extent, cmap="Greys", alpha=0.6)
        for x1, y1, x2, y2 in map_.lines:
            axes.plot((x1, x2), (y1, y2), color="#3d4248", linewidth=1.0)
    for number, (robot, path) in enumerate(record.paths.items()):
        ink = _COLOURS[number % len(_COLOURS)]
        axes.plot([x for x, _ in path], [y for _, y in path], color=ink, linewidth=0.8, alpha=0.7, label=robot)
    for room, (x, y) in record.rooms.items():
        axes.plot(x, y, "o", color="#3d4248", markersize=5)
        axes.annotate(room, (x, y), textcoords="offset points", xytext=(5, 4), fontsize=8)
    _mark_alarms(axes, [each.place for each in record.alarms.values()])
    axes.set_title("rooms, paths of the robots, and alarms", loc="left", fontsize=10)
    axes.set_aspect("equal", adjustable="box")
    axes.set_xlabel("x, m")
    axes.set_ylabel("y, m")
    if record.paths:
        axes.legend(frameon=False, fontsize=8, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    save_picture(page, file)


def draw_neglect(file: Path, record: NightRecord) -> None:
    """Draw how long each room was neglected over the night; SVG or PNG.

    Raises:
        ExtraMissing: matplotlib is not installed.
        OSError: The file cannot be written.
    """
    require("the picture of the neglect", "plots")
    from matplotlib.figure import Figure  # slow to import, and only needed here

    rooms = list(most_neglected(record))
    page = Figure(figsize=(8.0, 1.4 + 0.24 * len(rooms)), layout="constrained")
    axes = page.subplots()
    count = len(record.times)
    table = np.array([([0.0] * count + record.neglect[room])[-count:] for room in rooms]).reshape(len(rooms), count)
    lasted = record.times[-1] / 60.0 if record.times else 1.0
    shown = axes.imshow(
        table,
        aspect="auto",
        cmap="YlOrRd",
        vmin=0.0,
        interpolation="nearest",
        extent=(0.0, max(lasted, 0.01), len(rooms), 0.0),
    )
    page.colorbar(shown, ax=axes, label="s since the last visit", pad=0.01)
    for each in record.alarms.values():
        axes.axvline(each.time / 60.0, color="#1f77b4", linewidth=1.0, linestyle="--")
    axes.set_yticks([number + 0.5 for number in range(len(rooms))], rooms, fontsize=8)
    axes.set_title("time since the last visit of each room; alarms dashed", loc="left", fontsize=10)
    axes.set_xlabel("min")
    save_picture(page, file)


def _mark_alarms(axes: "Axes", places: Sequence[Point]) -> None:
    for number, (x, y) in enumerate(places, 1):
        axes.plot(x, y, "x", color="#b5382f", markersize=9, markeredgewidth=2.5)
        axes.annotate(str(number), (x, y), color="#b5382f", fontsize=9)

"""What is reported of missions of a file: a line for each, for people or as JSON, and a summary."""

import math
import statistics
from collections.abc import Sequence
from typing import Any

from acromovi.missions.judge import MissionVerdict
from acromovi.missions.matrix import Result
from acromovi.missions.mission_file import FileMission


def as_json(result: Result[FileMission]) -> dict[str, Any]:
    """Return the result as JSON. Figures that do not exist, as those of a way where there is none, are None.

    reached: it says that it is there, and truly is. touched: names of what it bumped into. path_over_shortest,
    time_over_best: beside the shortest way, at 0.5 m/s. clearance_m: room on either side of the robot on the widest
    way. off_m: from the goal at the end. seconds: of virtual time. why: why it was not reached; empty where it was.
    """
    mission, verdict, task = result.job, result.verdict, result.task
    entry = mission.entry
    said: dict[str, Any] = {
        "line": mission.line,
        "world": entry.world,
        "robot": entry.robot,
        "fit": list(entry.fit),
        "start": list(entry.start),
        "goal": list(entry.goal),
        "seed": entry.seed,
        "reached": verdict is not None and verdict.reached,
        "touched": list(verdict.touched) if verdict is not None else [],
        "path_over_shortest": _figure(verdict.over_shortest) if verdict is not None else None,
        "time_over_best": _figure(verdict.over_best_time) if verdict is not None else None,
        "clearance_m": task.clearance if task is not None else None,
        "seconds": _figure(verdict.seconds) if verdict is not None else None,
        "off_m": _figure(verdict.off) if verdict is not None else None,
        "why": why(result),
    }
    return said


def summary(results: Sequence[Result[FileMission]]) -> dict[str, Any]:
    """Return the counts, and the medians of the missions that were reached."""
    reached = [result.verdict for result in results if result.verdict is not None and result.verdict.reached]
    paths = [verdict.over_shortest for verdict in reached if math.isfinite(verdict.over_shortest)]
    times = [verdict.over_best_time for verdict in reached if math.isfinite(verdict.over_best_time)]
    return {
        "missions": len(results),
        "reached": len(reached),
        "touched": sum(result.verdict is not None and bool(result.verdict.touched) for result in results),
        "not_played": sum(result.verdict is None for result in results),
        "path_over_shortest_median": _figure(statistics.median(paths)) if paths else None,
        "time_over_best_median": _figure(statistics.median(times)) if times else None,
    }


def in_words(result: Result[FileMission]) -> str:
    """Return a line for people."""
    said = as_json(result)
    mark = "ok  " if result.is_good else "FAIL"
    figures = f"{said['path_over_shortest']} of the shortest way, " if said["path_over_shortest"] is not None else ""
    room = f"{100 * said['clearance_m']:.0f} cm beside it" if said["clearance_m"] is not None else "no way"
    reason = fault(said["why"], result.verdict)
    return f"{mark} {result.job.name}: {figures}{room}" + (f": {reason}" if reason else "")


def summary_in_words(results: Sequence[Result[FileMission]]) -> str:
    """Return the summary for people."""
    counted = summary(results)
    said = f"{counted['reached']} of {counted['missions']} reached, {counted['touched']} touched something"
    if counted["path_over_shortest_median"] is not None:
        said += f"; medians: {counted['path_over_shortest_median']} of the shortest way"
        said += f", {counted['time_over_best_median']} of the time that it takes at 0.5 m/s"
    return said


def why(result: Result[Any]) -> str:
    """Return why a mission was not reached; empty where it was."""
    if result.verdict is None:
        return result.error.strip().splitlines()[-1] if result.error else "it was not played"
    return result.verdict.why_not


def fault(why_not: str, verdict: MissionVerdict | None) -> str:
    """Return what was wrong with a mission in a line: why it was not reached, and what the robot touched."""
    if verdict is None:
        return f"not played: {why_not}"
    touched = f"touched {', '.join(verdict.touched)}" if verdict.touched else ""
    return "; ".join(filter(None, (why_not, touched)))


def _figure(value: float) -> float | None:
    return round(value, 3) if math.isfinite(value) else None

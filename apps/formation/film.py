"""The film of a formation: robots, trajectories and virtual points from above."""

from pathlib import Path

from apps.film import FilmWriter, TopView, moments
from apps.formation.record import FormationRecord


def write_film(file: Path, record: FormationRecord) -> int:
    """Write a record as a film; returns the number of frames.

    Raises:
        OSError: The file cannot be written.
    """
    view, writer = TopView(record.poses), FilmWriter(file)
    for moment in moments(record.times):
        points = [found for each in record.points.values() if (found := each[moment]) is not None]
        writer.add(view.draw(moment, f"{record.times[moment]:.1f} s", points))
    return writer.close()

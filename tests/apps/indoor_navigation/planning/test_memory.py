"""What the robot knows of the floor: who stands near bars the way, who is far away does not."""

import numpy as np
import pytest

from apps.indoor_navigation.algorithms.outline import Outline
from apps.indoor_navigation.algorithms.planning.memory import Memory
from apps.indoor_navigation.algorithms.planning.terrain import BARRED
from apps.indoor_navigation.data import ObstRead
from apps.indoor_navigation.parameters import shipped_parameters

BEAMS = np.radians(np.linspace(-90.0, 90.0, 181))
RADIUS, LEG = 0.35, 0.07  # m


def with_person(x: float, y: float, stamp: float) -> ObstRead:
    """A reading in the middle of a wide floor where somebody stands."""
    bearing, away = np.arctan2(y, x), np.hypot(x, y)
    is_leg = np.abs(BEAMS - bearing) < LEG / away
    lengths = np.where(is_leg, away, 7.9)
    nothing = np.zeros(len(BEAMS))
    ends = lengths * np.cos(BEAMS), lengths * np.sin(BEAMS)
    body = np.array([x]), np.array([y]), np.array([RADIUS]), np.array([0.0])
    return ObstRead(stamp, (0.0, 0.0, 0.0), None, 0.0, nothing, nothing, *ends, is_leg.astype(float), False, *body)


@pytest.mark.parametrize(("away", "is_barred"), [(2.0, True), (5.0, False)])
def test_only_who_stands_near_bars_a_way(away: float, is_barred: bool) -> None:
    memory = Memory(shipped_parameters("path_planning").mission.guide.memory, Outline(0.2, 0.3, 0.4))
    for step in range(50):
        memory.see(with_person(away, 0.0, 0.1 * step))
    ground = memory.survey((7.0, 0.0), 5.0)
    assert ground is not None
    here, beside = ground.costs(np.array([away, away]), np.array([0.0, 1.5]), np.zeros(2))
    assert (here >= BARRED) == is_barred
    assert here > beside + 2.0, "another way is better in any case"


def test_who_stands_still_does_not_become_a_wall() -> None:
    memory = Memory(shipped_parameters("path_planning").mission.guide.memory, Outline(0.2, 0.3, 0.4))
    for step in range(200):
        memory.see(with_person(2.0, 0.0, 0.1 * step))
    area = memory.grid.area
    assert area.occupied[area.cell(2.0, 0.0)]
    assert not area.walls[area.cell(2.0, 0.0)]
    assert not area.staying[area.cell(2.0, 0.0)]

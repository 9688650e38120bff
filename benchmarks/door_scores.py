"""How well a door detector does, by the truth of generated scans."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from math import cos, hypot, pi

from apps.indoor_navigation.data import Door, LaserRead
from benchmarks.door_scans import Case

NEAR = 0.3  # m between the middles of a door and what is taken for it
ASTRAY = 0.5  # rad, likewise between their normals

Detector = Callable[[LaserRead], tuple[Door, ...]]


@dataclass(slots=True)
class Score:
    """found, missed: doors that must be found. invented: what is no door. neither: doors seen too badly to count.

    off: m from the true middle, of each that was found. width_off: m from the true width.
    """

    found: int = 0
    missed: int = 0
    invented: int = 0
    neither: int = 0
    off: list[float] = field(default_factory=list)
    width_off: list[float] = field(default_factory=list)
    wrong_seeds: dict[int, str] = field(default_factory=dict)

    @property
    def precision(self) -> float:
        """The part of what was found and counts that is a door."""
        return self.found / max(1, self.found + self.invented)

    @property
    def recall(self) -> float:
        """The part of the doors that must be found that was."""
        return self.found / max(1, self.found + self.missed)

    def add(self, case: Case, doors: Iterable[Door]) -> None:
        """Count what was found in one scan."""
        left = list(case.sights)
        for door in doors:
            sight = min((s for s in left if _matches(s.door, door)), key=lambda s: _apart(s.door, door), default=None)
            if sight is None:
                self.invented += 1
                self.wrong_seeds[case.seed] = "invented"
                continue
            left.remove(sight)
            if sight.is_sure:
                self.found += 1
                self.off.append(_apart(sight.door, door))
                self.width_off.append(abs(sight.door.width - door.width))
            else:
                self.neither += 1
        missed = sum(sight.is_sure for sight in left)
        if missed:
            self.missed += missed
            self.wrong_seeds.setdefault(case.seed, "missed")


def score(detect: Detector, cases: Iterable[Case]) -> Score:
    """Let a detector look at scans."""
    total = Score()
    for case in cases:
        total.add(case, detect(case.scan))
    return total


def _apart(one: Door, other: Door) -> float:
    return hypot(one.x - other.x, one.y - other.y)


def _matches(truth: Door, door: Door) -> bool:
    return _apart(truth, door) < NEAR and cos(truth.normal - door.normal) > cos(ASTRAY) and -pi <= door.normal <= pi

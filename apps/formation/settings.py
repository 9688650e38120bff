"""Settings of the application, from one file; `settings.toml` beside this module has all of them with their meaning."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import configs
from configs.settings import ShippedSettings


@dataclass(frozen=True, slots=True)
class Points:
    """Where the virtual points are. follow: `path` or `frame`."""

    follow: str
    spacing_m: float
    column_spacing_m: float


@dataclass(frozen=True, slots=True)
class Poses:
    """How the robots' sonar corrects their odometry, and how exact both are."""

    correct: bool
    range_m: float
    front_m: float
    rear_m: float
    width_m: float
    half_cone_rad: float
    slant_rad: float
    noise_m: float
    gate: float
    most_m: float
    start_m: float
    start_rad: float
    bend_rad_m: float
    slip_m: float
    turn_rad: float
    turn_share: float


@dataclass(frozen=True, slots=True)
class SightSettings:
    """How poses follow from the sight of the leader's target."""

    spacing_m: float
    turn_rad_s: float
    at_point_m: float
    turned_rad: float
    blur_m: float
    gather_s: float
    blind_s: float
    unled_s: float
    gaze_s: float
    aside_rad: float


@dataclass(frozen=True, slots=True)
class Tracking:
    """How a follower drives to its point."""

    gain: float
    turn_gain: float
    lag_s: float
    speed_m_s: float
    turn_rad_s: float
    acceleration_m_s2: float
    at_point_m: float
    join_m: float


@dataclass(frozen=True, slots=True)
class Safety:
    """Distances and times of safety. radii_m: of robots of another size, by name."""

    radius_m: float
    radii_m: Mapping[str, float]
    robot_gap_m: float
    stop_gap_m: float
    obstacle_gap_m: float
    horizon_s: float
    braking_m_s2: float
    silent_s: float


@dataclass(frozen=True, slots=True)
class _Members:
    """What counts as lost. when_stopped: `leave` or `wait`."""

    when_stopped: str
    stuck_s: float
    lost_m: float
    back_m: float


@dataclass(frozen=True, slots=True)
class Passages:
    """How narrow places are seen."""

    ahead_m: float
    gap_m: float
    echoes: int
    range_m: float
    remember_s: float
    clear_s: float


@dataclass(frozen=True, slots=True)
class FormationSettings(ShippedSettings):
    """All settings; each is described in `settings.toml`."""

    SHIPPED = Path(__file__).with_name("settings.toml")

    period_s: float
    report_s: float
    points: Points
    poses: Poses
    sight: SightSettings
    tracking: Tracking
    safety: Safety
    members: _Members
    passages: Passages

    @property
    def by_sight(self) -> "FormationSettings":
        """The settings where poses come from sight: wider, with smaller turns, and without the sonar's corrections."""
        return replace(
            self,
            points=replace(self.points, spacing_m=self.sight.spacing_m, column_spacing_m=self.sight.spacing_m),
            poses=replace(self.poses, correct=False),
            tracking=replace(self.tracking, turn_rad_s=self.sight.turn_rad_s, at_point_m=self.sight.at_point_m),
        )

    def radius(self, robot: str) -> float:
        """Return the radius of a robot, m."""
        return self.safety.radii_m.get(robot, self.safety.radius_m)

    def check(self, source: str) -> None:
        """See that the settings fit together."""
        for name, word, allowed in (
            ("points.follow", self.points.follow, ("path", "frame")),
            ("members.when_stopped", self.members.when_stopped, ("leave", "wait")),
        ):
            if word not in allowed:
                raise configs.ConfigError(f"{source}: {name} must be {' or '.join(allowed)}, not {word!r}")

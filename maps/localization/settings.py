"""Settings of the localization; the file settings.toml has the values with their reasons."""

from dataclasses import dataclass
from pathlib import Path

from configs.settings import ShippedSettings


@dataclass(frozen=True, slots=True)
class FieldSettings:
    """How likely ranges are; m, rad."""

    cell: float
    laser_sigma: float
    sonar_sigma: float
    clutter: float
    beams: int
    laser_range: float
    sonar_range: float
    laser_weight: float
    sonar_weight: float
    sonar_half_angle: float
    arc_points: int


@dataclass(frozen=True, slots=True)
class MotionNoise:
    """Standard deviations of odometry, and the steps between two updates; m, rad."""

    distance_per_m: float
    turn_per_turn: float
    turn_per_m: float
    least_distance: float
    least_turn: float
    step: float
    step_turn: float


@dataclass(frozen=True, slots=True)
class ParticleSettings:
    """How many particles there are."""

    least: int
    most: int
    error: float
    quantile: float
    bin: float
    bin_turn: float
    start_sigma: float
    start_turn: float
    injected: float


@dataclass(frozen=True, slots=True)
class PoseSearchSettings:
    """The search of a pose in the whole map."""

    cell: float
    turn: float
    points: int
    kept: int
    refined: int
    every: float


@dataclass(frozen=True, slots=True)
class ReadingMemorySettings:
    """Which readings are remembered."""

    keyframe: float
    keyframe_turn: float
    longest: float
    scans: int
    thin: float


@dataclass(frozen=True, slots=True)
class SensorTrust:
    """When the readings of a kind of sensor confirm a pose."""

    near: float
    good: float
    poor: float
    margin: float
    close: float
    enough: float
    rival: float


@dataclass(frozen=True, slots=True)
class TrustSettings:
    """When a pose is believed, and when it is given up."""

    apart: float
    apart_turn: float
    travel: float
    confirmed: float
    patience: float
    wrong_map: float
    weight: float
    silence: float
    laser: SensorTrust
    sonar: SensorTrust


@dataclass(frozen=True, slots=True)
class OdometrySettings:
    """Estimation of systematic errors of odometry."""

    window: float
    memory: float
    distance_sigma: float
    turn_sigma: float
    drift_sigma: float


@dataclass(frozen=True, slots=True)
class LocalizationSettings(ShippedSettings):
    """All of them."""

    SHIPPED = Path(__file__).with_name("settings.toml")

    field: FieldSettings
    motion: MotionNoise
    particles: ParticleSettings
    search: PoseSearchSettings
    memory: ReadingMemorySettings
    trust: TrustSettings
    odometry: OdometrySettings

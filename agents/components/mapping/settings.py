"""Settings of the mapping agent; `settings.toml` beside this module has all of them with their meaning."""

from dataclasses import dataclass
from pathlib import Path

from configs.settings import ShippedSettings
from maps.building.laser_builder import MappingSettings
from maps.building.sonar import SonarMapping


@dataclass(frozen=True, slots=True)
class MapOutput:
    """What is published and written: m of a grid's cell, and s between two maps on the bus at least."""

    resolution_m: float
    publish_period_s: float


@dataclass(frozen=True, slots=True)
class MappingAgentSettings(ShippedSettings):
    """All settings of the agent."""

    SHIPPED = Path(__file__).with_name("settings.toml")

    laser: MappingSettings
    sonar: SonarMapping
    output: MapOutput

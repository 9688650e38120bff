"""Settings of the mapping agent; `settings.toml` beside this module has all of them with their meaning."""

from dataclasses import dataclass
from pathlib import Path

from configs.settings import load_with_changes
from maps.building.laser_builder import MappingSettings
from maps.building.sonar import SonarMapping

SETTINGS = Path(__file__).with_name("settings.toml")


@dataclass(frozen=True, slots=True)
class MapOutput:
    """What is published and written: m of a grid's cell, and s between two maps on the bus at least."""

    resolution_m: float
    publish_period_s: float


@dataclass(frozen=True, slots=True)
class MappingAgentSettings:
    """All settings of the agent."""

    laser: MappingSettings
    sonar: SonarMapping
    output: MapOutput

    @classmethod
    def load(cls) -> "MappingAgentSettings":
        """Read them.

        Raises:
            ConfigError: The file is not valid.
        """
        return load_with_changes(cls, SETTINGS, None)[0]

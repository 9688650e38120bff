"""The services of a team, as `acromovi container --services` starts them."""

import asyncio
from pathlib import Path

import pytest

from acromovi.container import start_services
from agents.platform import AgentName, AgentState, Container
from agents.services.all_services import SERVICES
from bus import MemoryBus
from configs import ConfigError


def test_services_live_on_the_teams_platform_with_the_properties_they_are_given(tmp_path: Path) -> None:
    file = tmp_path / "leases.jsonl"

    async def main() -> None:
        with MemoryBus() as bus:
            async with Container(bus, "services") as container:
                await start_services(container, "dwarfs", {"arbiter.audit_file": str(file)})
                states = {local: container.agent(AgentName(local, "dwarfs")).state for local in SERVICES}
                assert states == dict.fromkeys(SERVICES, AgentState.ACTIVE)

    asyncio.run(main())
    assert file.exists()


@pytest.mark.parametrize("name", ["arbitre.audit_file", "arbiter", "audit_file"])
def test_property_of_no_service_is_told(name: str) -> None:
    with pytest.raises(ConfigError, match="is no property of a service"):
        asyncio.run(start_services(Container(MemoryBus(), "services"), "dwarfs", {name: 1}))

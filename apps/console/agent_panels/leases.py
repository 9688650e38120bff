"""The panel of the leases of all robots."""

from agents.services.gateway_leases import held_leases
from apps.console.data_view import DataTable
from apps.console.program import Console
from bus import BusError


class LeasesPanel:
    """Who holds what, as the gateways of the robots know it."""

    def __init__(self, console: Console) -> None:
        """Add it to the page."""
        self._console = console
        self._table = DataTable(("Element", "Holder", "Priority", "Expires in"), "nobody holds a lease")

    async def refresh(self) -> None:
        """Read them again."""
        try:
            rows, _ = await held_leases(self._console.agent.bus)
        except (BusError, TimeoutError):
            return  # the bus is closed; what was shown stays until the page ends
        self._table.show(
            [
                [str(row["element"]), str(row["holder"]), str(row["priority"]), f"{row['expires_in']:.1f} s"]
                for row in rows
            ]
        )

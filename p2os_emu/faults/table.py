"""All the faults there are."""

from collections.abc import Mapping

from p2os_emu.faults import accessories, lines, machine, power
from p2os_emu.faults.kind import FaultKind

FAULTS: Mapping[str, FaultKind] = {
    kind.name: kind for kind in (*machine.KINDS, *power.KINDS, *accessories.KINDS, *lines.KINDS)
}
"""By name."""

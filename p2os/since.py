"""Since when firmware knows a command.

Written as the manuals do: `P2 1.4, A 1.0, C` is P2OS 1.4, AROS 1.0 and any ARCOS. Firmware is a line of descent: what
an older family knew, a younger one knows too, unless it is listed with a version of its own.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

from p2os.firmware import Family

_FAMILIES = {
    "P2": Family.P2OS,
    "A": Family.AROS,
    "C": Family.ARCOS,
    "AmigOS": Family.AMIGOS,
}
_DESCENT = {
    Family.P2OS: (Family.P2OS,),
    Family.AROS: (Family.AROS, Family.P2OS),
    Family.AMIGOS: (Family.AMIGOS, Family.AROS, Family.P2OS),
    Family.ARCOS: (Family.ARCOS, Family.AROS, Family.P2OS),
    Family.UARCS: (Family.ARCOS, Family.AROS, Family.P2OS),
}
"""Families from a family to its ancestors; uARCS is taken for ARCOS and AmigOS for AROS."""


@dataclass(frozen=True, slots=True)
class Since:
    """Since when.

    text: as it is printed. versions: the first version of each family listed, () for any; where none is listed no
    source says who knows the command, and everybody may.
    """

    text: str
    versions: Mapping[Family, tuple[int, ...]] = field(hash=False)

    @classmethod
    def read(cls, text: str) -> "Since":
        """Parse an entry of the command table; words that name no family are ignored."""
        versions: dict[Family, tuple[int, ...]] = {}
        for entry in text.split(","):
            name, version, *_ = (*entry.split(), "")
            if name in _FAMILIES:
                versions[_FAMILIES[name]] = _version(version) if version[:1].isdigit() else ()
        return cls(text, versions)

    def __str__(self) -> str:
        return self.text

    def known_to(self, family: Family, version: str) -> bool:
        """Return whether firmware of a family and version, such as "1.M", knows the command."""
        if not self.versions:
            return True
        for relative in _DESCENT[family]:
            if relative in self.versions:
                own = relative in (family, _DESCENT[family][0])
                return not own or _version(version) >= self.versions[relative]
        return False


def _version(text: str) -> tuple[int, ...]:
    """A version as numbers that compare: after 1.9 comes 1.A.

    Raises:
        ValueError: It is none.
    """
    return tuple(int(part, 36) for part in text.split("."))

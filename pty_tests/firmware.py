"""Which firmware a robot runs, and which commands it knows: tests ask a robot only for what its firmware knows.

Since when firmware knows a command: the Pioneer 2 (P2OS), Pioneer 3/2 H8 (AROS), Pioneer 3 (ARCOS) and AmigoBot
operations manuals. Where a CONFIGpac ends: the H8 manual, and ARIA's reader of it.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import pytest

from pty_tests.client import CONFIG, ENCODER, ESTOP, HOSTBAUD, IOREQUEST, RESET, ROTATE, SONARCYCLE
from pty_tests.models import MODELS

P2OS, AROS, AMIGOS, ARCOS = "P2OS", "AROS", "AmigOS", "ARCOS"
DESCENT = {P2OS: (P2OS,), AROS: (AROS, P2OS), AMIGOS: (AMIGOS, AROS, P2OS), ARCOS: (ARCOS, AROS, P2OS)}
"""A family, and those before it: what an older one knew, a younger one knows, unless a version of its own is listed."""
SHORT_SIP, ARCOS_SIP = 0, 7
"""Bytes of a standard SIP after the digital outputs."""

ADSEL, BUMPSTALL, BATTEST, ONE_ARRAY = 35, 44, 250, -28
"""ONE_ARRAY: SONAR for a single array; the plain SONAR is older."""

_GAIN = {P2OS: "1.M", AROS: "1.1", ARCOS: ""}
SINCE: Mapping[int, tuple[str, Mapping[str, str]]] = {
    ROTATE: ("ROTATE", {AROS: "1.0"}),
    CONFIG: ("CONFIG", {P2OS: "1.4"}),
    ENCODER: ("ENCODER", {P2OS: "1.4"}),
    ONE_ARRAY: ("SONAR for one array", {AROS: "1.0"}),
    ADSEL: ("ADSEL", {ARCOS: "1.0"}),
    38: ("GYROCALCW", {ARCOS: "2.0"}),
    39: ("GYROCALCCW", {ARCOS: "2.0"}),
    IOREQUEST: ("IOREQUEST", {P2OS: "1.E"}),
    BUMPSTALL: ("BUMPSTALL", {P2OS: "1.5", ARCOS: ""}),
    SONARCYCLE: ("SONARCYCLE", {AROS: "1.8", ARCOS: ""}),
    HOSTBAUD: ("HOSTBAUD", {AROS: "", ARCOS: "1.0"}),
    ESTOP: ("ESTOP", {P2OS: "1.8"}),
    82: ("ROTKP", _GAIN),
    83: ("ROTKV", _GAIN),
    84: ("ROTKI", _GAIN),
    85: ("TRANSKP", _GAIN),
    86: ("TRANSKV", _GAIN),
    87: ("TRANSKI", _GAIN),
    88: ("REVCOUNT", {AROS: "1.1", ARCOS: "1.1"}),
    89: ("DRIFTFACTOR", {ARCOS: "1.0"}),
    93: ("TICKSMM", {ARCOS: "1.1"}),
    BATTEST: ("BATTEST", {ARCOS: "1.0"}),  # the same number shuts down the computer of an AROS robot
    RESET: ("RESET", {ARCOS: "1.0"}),
}
"""Commands of which a test demands an effect: name, and the first version of each family listed; "" for any version."""

AROS_CONFIGPAC = (("auto_baud", "1.8"), ("charger", "1.7"), ("front_bumpers", "1.6"))
"""Fields that a CONFIGpac has since these versions of AROS, the youngest first."""

ROBOT_RUNS = "; the robot runs "
"""What a reason to skip ends with, before the firmware."""


@dataclass(frozen=True, slots=True)
class Firmware:
    """What a robot runs.

    family: one of `DESCENT`. version: the least that it can be, such as "1.4". source: how it is known.
    """

    family: str
    version: str
    source: str

    def __str__(self) -> str:
        return f"{self.family} {self.version} ({self.source})"

    @property
    def sip_tail(self) -> int:
        """Bytes after the digital outputs in the standard SIP."""
        return ARCOS_SIP if self.family == ARCOS else SHORT_SIP

    def knows(self, number: int) -> bool:
        """Whether it surely knows a command; of those that are not in `SINCE` no test demands an effect."""
        if number not in SINCE:
            return True
        _, since = SINCE[number]
        for family in DESCENT[self.family]:
            if family in since:
                # AmigOS counts its versions as AROS does, as far as its CONFIGpac tells.
                own = family == self.family or (self.family == AMIGOS and family == AROS)
                return not own or order(self.version) >= order(since[family])
        return False

    def require(self, number: int) -> None:
        """Skip the test that asks, if this firmware does not know a command."""
        if not self.knows(number):
            name, since = SINCE[number]
            versions = ", ".join(f"{family} {version}".strip() for family, version in since.items())
            pytest.skip(f"{name} came with {versions}{ROBOT_RUNS}{self}")


def order(version: str) -> tuple[int, ...]:
    """A version as numbers that compare: after 1.9 comes 1.A; the empty one comes before all."""
    return tuple(int(part, 36) for part in version.split(".")) if version else ()


def told(text: str) -> Firmware:
    """Return the firmware that a person names, such as `P2OS 1.M`.

    Raises:
        ValueError: There is no such family, or the version is none.
    """
    family, _, version = text.partition(" ")
    known = {name.lower(): name for name in DESCENT}
    if family.lower() not in known:
        raise ValueError(
            f"there is no firmware {family!r}; give one of {', '.join(DESCENT)} and a version, as P2OS 1.M"
        )
    try:
        order(version)
    except ValueError:
        raise ValueError(f"{version!r} is no version of {family}; write it as 1.8 or 1.M") from None
    return Firmware(known[family.lower()], version or "1.0", "as --firmware says")


def reported(subtype: str, configuration: Mapping[str, int | str] | None) -> Firmware:
    """Return the firmware that a robot reports.

    Args:
        subtype: As the handshake announces it.
        configuration: Fields of its CONFIGpac; None where it does not answer CONFIG.
    """
    named = MODELS[subtype].firmware if subtype in MODELS else P2OS
    if configuration is None:
        return Firmware(named, "1.0", "it does not answer CONFIG")
    if version := configuration.get("firmware_version"):
        return Firmware(ARCOS, str(version), "as its CONFIGpac says")
    if "drift_factor" in configuration:
        return Firmware(ARCOS, "1.0", "its CONFIGpac has no version")
    *_, last = configuration
    for field, version in AROS_CONFIGPAC:
        if field in configuration:
            return Firmware(AMIGOS if named == AMIGOS else AROS, version, f"its CONFIGpac ends with {last}")
    if named in (AROS, AMIGOS):
        return Firmware(named, "1.0", f"its CONFIGpac ends with {last}")
    return Firmware(P2OS, "1.4", f"or later: its CONFIGpac ends with {last} and has no version")

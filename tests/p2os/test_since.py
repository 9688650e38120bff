import pytest

from p2os import COMMANDS, FIRMWARES, Command, Family
from p2os.command_table import known_commands
from p2os.since import Since


@pytest.mark.parametrize(
    ("text", "family", "version", "known"),
    [
        ("all", Family.P2OS, "1.0", True),
        ("P2 1.4", Family.P2OS, "1.3", False),
        ("P2 1.4", Family.P2OS, "1.4", True),
        ("P2 1.E", Family.P2OS, "1.9", False),
        ("P2 1.E", Family.P2OS, "1.M", True),
        ("P2 1.4", Family.AROS, "1.0", True),  # younger families inherit
        ("P2 1.4", Family.ARCOS, "1.0", True),
        ("P2 1.4, A 1.8", Family.AROS, "1.7", False),  # unless they are listed themselves
        ("P2 1.4, A 1.8", Family.ARCOS, "1.0", True),
        ("A 1.0", Family.P2OS, "1.M", False),
        ("C", Family.AROS, "1.8", False),
        ("C", Family.ARCOS, "1.0", True),
        ("C 2.0", Family.ARCOS, "1.9", False),
        ("C 2.0", Family.UARCS, "2.8", True),
        ("C 2.0", Family.UARCS, "1.9", False),
        ("AmigOS", Family.AMIGOS, "1.0", True),
        ("AmigOS", Family.AROS, "1.8", False),
        ("A 1.1, C 1.0, AmigOS 1.3", Family.AMIGOS, "1.2", False),
        ("A 1.1", Family.AMIGOS, "1.3", True),
        ("library", Family.P2OS, "1.0", True),  # no source tells: let it pass
        ("C (number unverified)", Family.ARCOS, "1.0", True),
        ("PSOS 4.5, P2 1.2", Family.P2OS, "1.M", True),
    ],
)
def test_firmware_knows_what_its_family_and_its_ancestors_brought_in(
    text: str, family: Family, version: str, known: bool
) -> None:
    assert Since.read(text).known_to(family, version) is known


def test_versions_count_on_with_letters() -> None:
    versions = ["1.0", "1.4", "1.9", "1.A", "1.M", "2.0", "2.8"]
    for at, first in enumerate(versions):
        known = [Since.read(f"P2 {first}").known_to(Family.P2OS, version) for version in versions]
        assert known == [False] * at + [True] * (len(versions) - at)


def test_a_version_is_none_without_digits() -> None:
    with pytest.raises(ValueError, match="base 36"):
        Since.read("P2 1.-")


EVERYWHERE = "SETV SETA SETRV SETRA SONAR SETO ENABLE VEL RVEL VEL2 HEAD STOP CONFIG BATTERYINFO GETAUX TTY2"
FIRST_WORDS = {
    Family.P2OS: "IOREQUEST JOYDRIVE ARM_STATUS",
    Family.AROS: "IOREQUEST HOSTBAUD GYRO GRIPREQUEST ARM_STATUS",
    Family.AMIGOS: "SOUND GETAUX2 TTY3",
    Family.ARCOS: "IOREQUEST HOSTBAUD GYRO JOYREQUEST JOYDRIVE GRIPREQUEST ADSEL TICKSMM DRIFTFACTOR REVCOUNT",
    Family.UARCS: "IOREQUEST HOSTBAUD",
}
"""What clients send before a person touches anything. Source: fact sheet section 11, client quirks sections 2 to 4."""


@pytest.mark.parametrize("family", Family)
def test_every_family_knows_what_clients_begin_with(family: Family) -> None:
    known = known_commands(family, FIRMWARES[family].version)
    assert {Command[name] for name in f"{EVERYWHERE} {FIRST_WORDS[family]}".split()} <= known


def test_families_differ() -> None:
    known = {family: known_commands(family, row.version) for family, row in FIRMWARES.items()}
    assert known[Family.P2OS] < known[Family.AROS] < known[Family.ARCOS] == known[Family.UARCS]
    assert known[Family.AMIGOS] - known[Family.AROS] == {Command.SOUND}
    assert Command.HOSTBAUD not in known[Family.P2OS]
    assert Command.TICKSMM not in known[Family.AROS]


def test_the_text_is_printed_as_it_was_read() -> None:
    assert str(COMMANDS[Command.HOSTBAUD].since) == "A, C 1.0"

"""What the suite takes a robot's firmware for, and what it therefore asks."""

import pytest

from pty_tests.client import CONFIG, ENABLE, ESTOP, RESET, ROTATE, SONARCYCLE
from pty_tests.firmware import BATTEST, Firmware, reported, told

OLDEST = {"trans_ki": 0}


@pytest.mark.parametrize(
    ("subtype", "configuration", "family", "version"),
    [
        ("p2dx", None, "P2OS", "1.0"),
        ("p2dx", OLDEST, "P2OS", "1.4"),
        ("unheard-of", OLDEST, "P2OS", "1.4"),
        ("p3dx", OLDEST, "AROS", "1.0"),
        ("unheard-of", OLDEST | {"front_bumpers": 5, "rear_bumpers": 5}, "AROS", "1.6"),
        ("p3dx", OLDEST | {"front_bumpers": 5, "charger": 0}, "AROS", "1.7"),
        ("p3dx", OLDEST | {"front_bumpers": 5, "charger": 0, "auto_baud": 1}, "AROS", "1.8"),
        ("amigo", OLDEST | {"front_bumpers": 0, "charger": 0, "auto_baud": 1}, "AmigOS", "1.8"),
        ("p3dx-sh", OLDEST | {"auto_baud": 1, "drift_factor": 0}, "ARCOS", "1.0"),
        ("p2dx", OLDEST | {"auto_baud": 1, "drift_factor": 0, "firmware_version": "2.8"}, "ARCOS", "2.8"),
    ],
)
def test_firmware_follows_from_where_the_configpac_ends_and_from_the_subtype(
    subtype: str, configuration: dict[str, int | str] | None, family: str, version: str
) -> None:
    firmware = reported(subtype, configuration)
    assert (firmware.family, firmware.version) == (family, version)


@pytest.mark.parametrize(
    ("firmware", "number", "known"),
    [
        ("P2OS 1.0", ENABLE, True),
        ("P2OS 1.0", CONFIG, False),
        ("P2OS 1.4", CONFIG, True),
        ("P2OS 1.7", ESTOP, False),
        ("P2OS 1.M", ESTOP, True),
        ("P2OS 1.M", ROTATE, False),
        ("AROS 1.0", ESTOP, True),
        ("AROS 1.7", SONARCYCLE, False),
        ("AROS 1.8", SONARCYCLE, True),
        ("AmigOS 1.7", SONARCYCLE, False),
        ("AROS 1.8", BATTEST, False),  # it would shut down the computer
        ("AROS 1.8", RESET, False),
        ("ARCOS 1.0", RESET, True),
        ("ARCOS 1.0", SONARCYCLE, True),
    ],
)
def test_a_younger_family_knows_what_an_older_one_knew(firmware: str, number: int, known: bool) -> None:
    assert told(firmware).knows(number) is known


def test_a_command_that_is_not_known_is_a_reason_to_skip_that_names_both() -> None:
    with pytest.raises(pytest.skip.Exception, match=r"RESET came with ARCOS 1\.0; the robot runs AROS 1\.8 \(here\)"):
        Firmware("AROS", "1.8", "here").require(RESET)


@pytest.mark.parametrize("text", ["", "MacOS 9", "P2OS 1-4"])
def test_firmware_that_there_is_not_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match=r"there is no firmware|is no version of"):
        told(text)

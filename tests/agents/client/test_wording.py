"""A program reads what to call, and not what to send to a gateway."""

import re
from pathlib import Path

import pytest

import gateway
from agents.client.wording import in_api_words

FOLDER = Path(gateway.__file__).parent


@pytest.mark.parametrize(
    ("why", "says"),
    [
        ('the arm has no power; send arm {"do": "power", "on": true}', "the arm has no power; call arm.power(True)"),
        (
            'the arm does not know where its joints are; send arm {"do": "home"}',
            "the arm does not know where its joints are; call arm.home()",
        ),
        ('latched; send estop {"on": false} first', "latched; call base.estop(False) first"),
        (
            'the e-stop is latched; send estop {"on": false} and then enable {"on": true}',
            "the e-stop is latched; call base.estop(False) and then base.enable(True)",
        ),
        ('the motors are off; send enable {"on": true}', "the motors are off; call base.enable(True)"),
        ('switch it on: send sonar {"on": true}', "switch it on: call sonar.power(True)"),
        ('needs pan, tilt or zoom, or {"do": "stop"}', "needs pan, tilt or zoom, or arm.stop()"),
        ('arm move needs joints, such as {"1": 0.5}', 'arm move needs joints, such as {"1": 0.5}'),
        (
            "anna holds the arm; a command needs its token",
            "anna holds the arm; wait, or take it over with arm.lease(priority=...)",
        ),
        ("send arm {nonsense}", "send arm {nonsense}"),
        ("", ""),
    ],
)
def test_advice_is_a_call(why: str, says: str) -> None:
    assert in_api_words(why, "arm") == says


def test_all_that_gateways_advise_can_be_told() -> None:
    advice = [
        found
        for file in FOLDER.rglob("*.py")
        for found in re.findall(r"\bsend \w+ \{\"[^}]*\}", file.read_text(encoding="utf-8"))
    ]
    assert len(advice) >= 5
    assert [each for each in advice if "{" in in_api_words(each, "base")] == []

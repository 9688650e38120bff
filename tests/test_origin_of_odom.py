"""The origin of `odom` is described in the same words everywhere; `tests/gateway/test_odometry.py` proves them."""

from pathlib import Path

import pytest

import apps.indoor_navigation.data as data
from acromovi.navigation import command
from agents.client.movers import BaseClient
from bus import keys
from gateway import odometry

ROOT = Path(__file__).resolve().parents[1]
WORDS = "where the robot stood when its gateway first connected"
PAGES = ("docs/gateway.md", "GLOSSARY.md", "docs/components.md", "docs/navigation.md")
TEXTS = {
    **{page: (ROOT / page).read_text(encoding="utf-8") for page in PAGES},
    "keys": keys.ODOM.meaning,
    "navigate --help": command.EPILOG,
    **{str(each.__name__): str(each.__doc__) for each in (BaseClient, data, odometry)},
}


@pytest.mark.parametrize("place", TEXTS)
def test_the_origin_of_odom_is_described_in_one_way(place: str) -> None:
    assert WORDS in " ".join(TEXTS[place].split())

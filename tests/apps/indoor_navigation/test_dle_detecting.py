"""The detection of doors on the bus, in virtual time."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from agents.platform.virtual_time import VirtualTimeLoop
from apps.indoor_navigation.components.dle_detecting import DLEDetecting
from apps.indoor_navigation.data import DLEData
from apps.indoor_navigation.wiring import load_wiring
from benchmarks.door_scans import make_case
from bus import Refused
from tests.apps.indoor_navigation.site import ROBOT, Site

SEEN = next(case for case in map(make_case, range(40_000_000, 40_000_100)) if any(s.is_sure for s in case.sights))


@pytest.fixture
def site() -> Iterator[Site]:
    loop = VirtualTimeLoop()
    site = Site(loop)
    site.start(DLEDetecting(f"dle_detecting@{ROBOT}", {"hears": [["laser_server", "LaserRead"]]}))
    yield site
    site.close()
    loop.close()


def test_each_scan_is_answered_by_its_doors(site: Site) -> None:
    pushed = site.pushed("dle_detecting", DLEData)
    for stamp in (1.0, 2.0):
        site.push("laser_server", replace(SEEN.scan, stamp=stamp))
        site.run(0.01)
    assert [each.stamp for each in pushed] == [1.0, 2.0]
    assert pushed[0].pose == SEEN.scan.pose
    assert pushed[0].doors


def test_a_scan_without_doors_is_told_too(site: Site) -> None:
    pushed = site.pushed("dle_detecting", DLEData)
    site.push("laser_server", replace(SEEN.scan, ranges=np.full(361, np.inf)))
    site.run(0.01)
    assert [each.doors for each in pushed] == [()]


def test_the_last_doors_are_told_to_who_asks(site: Site) -> None:
    pushed = site.pushed("dle_detecting", DLEData)
    with pytest.raises(Refused, match="has received no scan yet"):
        site.ask("dle_detecting", "doors")
    site.push("laser_server", SEEN.scan)
    site.run(0.01)
    assert DLEData.from_json(site.ask("dle_detecting", "doors")) == pushed[-1]


def test_the_wiring_has_it(site: Site) -> None:
    (part,) = (part for part in load_wiring().parts if part.local == "dle_detecting")
    assert ["laser_server", "LaserRead"] in part.properties["hears"]

"""The agents of both camera heads, from request to the emulated head and back, in virtual time."""

from typing import TYPE_CHECKING

import pytest

from agents.platform import Ending

if TYPE_CHECKING:
    from tests.agents.components.conftest import Lab, MakeLab

HALF_A_DEGREE = 0.01  # rad


@pytest.fixture(params=["ptz:vcc4", "ptz:evid30"])
def lab(request: pytest.FixtureRequest, make_lab: "MakeLab") -> "Lab":
    lab = make_lab(request.param)
    lab.until(lambda: "ptz" in lab.elements)
    return lab


def test_head_looks_where_it_is_told_and_answers_when_it_does(lab: "Lab") -> None:
    seen = lab.value("ptz", "look", pan=0.5, tilt=0.2, zoom=3.0)
    assert not seen["moving"]
    assert (seen["pan"], seen["tilt"]) == pytest.approx((0.5, 0.2), abs=HALF_A_DEGREE)
    assert seen["zoom"] == pytest.approx(3.0, rel=0.03)
    seen = lab.value("ptz", "look", pan=-0.5)
    assert (seen["pan"], seen["tilt"]) == pytest.approx((-0.5, 0.2), abs=HALF_A_DEGREE)
    seen = lab.value("ptz", "centre")
    assert (seen["pan"], seen["tilt"]) == pytest.approx((0.0, 0.0), abs=HALF_A_DEGREE)
    assert seen["zoom"] == pytest.approx(3.0, rel=0.03)


def test_head_that_looks_there_already_answers_soon(lab: "Lab") -> None:
    lab.value("ptz", "look", pan=0.5)
    began = lab.loop.time()
    lab.value("ptz", "look", pan=0.5)
    assert lab.loop.time() - began < 3.0


def test_gateways_limits_are_the_refusals(lab: "Lab") -> None:
    for given, why in (({"pan": 9.0}, "pan 9 rad is not within"), ({}, "ptz needs pan, tilt or zoom")):
        refused = lab.ask("ptz", "look", **given)
        assert refused.ending is Ending.REFUSED
        assert why in refused.why


def test_request_that_is_cancelled_stops_the_head(lab: "Lab") -> None:
    lab.value("ptz", "look", pan=-1.0)
    asking = lab.begin("ptz", "look", pan=1.0)
    lab.run(0.4)
    asking.cancel()
    lab.run(3.0)
    seen = lab.value("ptz", "read")
    assert not seen["moving"]
    assert -1.0 < seen["pan"] < 0.9


def test_newer_request_takes_the_place_of_an_older_one(lab: "Lab") -> None:
    older = lab.begin("ptz", "look", pan=1.0)
    lab.run(0.3)
    assert lab.value("ptz", "centre")["pan"] == pytest.approx(0.0, abs=HALF_A_DEGREE)
    assert lab.do(older).why == "ptz centre took the place of ptz look"


def test_head_that_is_told_to_stop_says_where_it_looks(lab: "Lab") -> None:
    lab.value("ptz", "look", pan=-1.0)
    older = lab.begin("ptz", "look", pan=1.0)
    lab.run(0.4)
    stopped = lab.value("ptz", "stop")
    assert not stopped["moving"]
    assert stopped["pan"] < 0.9
    assert lab.do(older).why == "ptz stop took the place of ptz look"

"""The wiring as it runs, drawn."""

import re
from typing import Any
from xml.etree import ElementTree

import pytest

from acromovi.navigation.wiring_picture import Seen, svg

SVG = "{http://www.w3.org/2000/svg}"
DESCRIPTION: dict[str, Any] = {
    "name": "path_planning@happy",
    "role": "deliberative",
    "state": "active",
    "container": "happy-planning",
    "properties": {
        "hears": [["dle_detecting", "DLEData"]],
        "tells": {"WorldCoord": ["goto", "orienting"]},
        "asks": {"load": "motion_fuser"},
        "numbers": {},
    },
}
PLANNING = Seen.from_description(DESCRIPTION)
GOTO = Seen("goto", "reactive", "happy-reactive", "suspended")
FUSER = Seen("motion_fuser", "reactive", "happy-reactive", hears=[("goto", "MotionCmd")])


def texts(drawing: str) -> list[str]:
    return [text.text or "" for text in ElementTree.fromstring(drawing).iter(f"{SVG}text")]


def arrows(drawing: str) -> list[str]:
    titles = [title.text or "" for title in ElementTree.fromstring(drawing).iter(f"{SVG}title")]
    return [title for title in titles if "→" in title]


def test_components_are_boxes_and_what_flows_are_arrows_of_three_kinds() -> None:
    drawing = svg("happy", [PLANNING, GOTO, FUSER])
    assert {"path_planning", "goto", "motion_fuser", "deliberative", "reactive"} <= set(texts(drawing))
    assert arrows(drawing) == [
        "goto → motion_fuser: push MotionCmd",
        "path_planning → goto: send WorldCoord",
        "path_planning → motion_fuser: query load",
    ]
    assert {"url(#push)", "url(#send)", "url(#query)"} == set(re.findall(r"url\(#\w+\)", drawing))


def test_who_is_pushed_something_stands_below_who_pushes_it() -> None:
    drawing = ElementTree.fromstring(svg("happy", [GOTO, FUSER]))
    heights = {text.text: float(text.get("y", 0)) for text in drawing.iter(f"{SVG}text")}
    assert heights["goto"] < heights["motion_fuser"]


def test_processes_are_shades_and_a_state_that_is_not_active_is_told() -> None:
    drawing = svg("happy", [PLANNING, GOTO, FUSER])
    assert {"the process of happy-planning", "the process of happy-reactive"} <= set(texts(drawing))
    assert "happy-reactive: suspended" in texts(drawing)
    assert drawing.count("#dbeafe") == 2  # planning's box and its line in the legend
    assert drawing.count("#dcfce7") == 3


def test_a_dead_component_is_missing_and_named_below() -> None:
    drawing = svg("happy", [PLANNING, FUSER])
    assert "goto" not in texts(drawing)
    assert "not there, though others are wired to them: dle_detecting, goto, orienting" in texts(drawing)
    assert arrows(drawing) == ["path_planning → motion_fuser: query load"]


def test_a_drawing_of_nobody_says_so() -> None:
    assert "Nobody navigates happy" in texts(svg("happy", []))


def test_what_components_say_is_escaped() -> None:
    drawing = svg("<&>", [Seen('<script>alert("x")</script>', "</svg>", "&amp;\x00")])
    assert "<script>" not in drawing
    assert '<script>alert("x")</script>' in texts(drawing)


def test_a_drawing_needs_no_other_file() -> None:
    assert re.findall(r"https?://[^\"'< ]+", svg("happy", [PLANNING, GOTO])) == ["http://www.w3.org/2000/svg"]


@pytest.mark.parametrize("missing", ["role", "properties", "container"])
def test_a_description_that_is_no_components_is_refused(missing: str) -> None:
    with pytest.raises(LookupError):
        Seen.from_description({key: value for key, value in DESCRIPTION.items() if key != missing})

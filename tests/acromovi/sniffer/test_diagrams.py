"""Sequence diagrams, as text and as SVG."""

import re
from xml.etree import ElementTree

import pytest

from acromovi.sniffer.sequence import diagram_of
from acromovi.sniffer.svg import svg
from acromovi.sniffer.text import lines
from tests.acromovi.sniffer.talking import A_TALK, APP, ARM, BASE, said

SVG = "{http://www.w3.org/2000/svg}"


def test_a_diagram_has_a_lifeline_for_each_agent_and_an_arrow_for_each_receiver() -> None:
    diagram = diagram_of(reversed(A_TALK))
    assert diagram.lifelines == [APP, BASE, ARM]
    assert [(arrow.start, arrow.end) for arrow in diagram.arrows] == [
        (0, 1),
        (1, 0),
        (1, 0),
        (1, 2),
        (1, 1),
        (1, 0),
        (0, 2),
    ]
    assert [arrow.colour for arrow in diagram.arrows] == [0, 0, None, None, None, 0, 1]


def test_the_text_has_a_line_for_each_arrow_from_lifeline_to_lifeline() -> None:
    names, head, *arrows, foot, again = lines(diagram_of(A_TALK))
    assert names == again
    assert names.split() == [APP, BASE, ARM]
    assert head == foot
    places = [place for place, letter in enumerate(head) if letter == "│"]
    left, middle, right = places
    assert [arrow[left] for arrow in arrows] == ["│"] * 7
    assert arrows[0][left : middle + 1].startswith("│─ request move distance=1.0 ")
    assert arrows[0].endswith("▶│" + " " * (right - middle - 1) + "│")
    assert arrows[1][left + 1] == "◀"
    assert "↺ inform" in arrows[4]
    assert "failure the wheels are stalled" in arrows[5]
    assert arrows[5].split()[1] == "c0ffee"
    assert arrows[6][middle] == "─", "an arrow crosses the lifelines between its ends"


@pytest.mark.parametrize("width", [20, 80, 120, 200])
def test_the_text_is_as_narrow_as_it_is_told_if_that_can_be(width: int) -> None:
    shown = list(lines(diagram_of(A_TALK), width))
    assert max(map(len, shown)) <= max(width, 80)
    assert len({len(line.rstrip()) for line in shown[1:-1] if line.endswith("│")}) == 1


def test_messages_that_no_longer_fit_are_counted() -> None:
    assert next(iter(lines(diagram_of(A_TALK, 7)))) == "7 earlier messages are left out"
    assert "7 before them left out" in svg(diagram_of(A_TALK, 7))


def test_a_diagram_of_nothing_says_so() -> None:
    assert list(lines(diagram_of([]))) == ["nobody said anything"]
    assert "Nobody said anything" in texts(svg(diagram_of([])))


def test_the_svg_stands_alone_and_has_names_times_arrows_and_labels() -> None:
    written = svg(diagram_of(A_TALK))
    root = ElementTree.fromstring(written)
    assert "href" not in written
    assert "url(" not in written.replace("url(#head", "")
    assert sum(name == BASE for name in texts(written)) == 2, "a box above and one below"
    arrows = [path for path in root.iter(f"{SVG}path") if "marker-end" in path.attrib]
    assert len(arrows) == 7
    assert arrows[0].get("stroke") == arrows[1].get("stroke") != arrows[6].get("stroke")
    assert sum(re.fullmatch(r"\d\d:\d\d:\d\d\.\d{3}", text) is not None for text in texts(written)) == 7
    assert "move distance=1.0" in written
    assert "conversation c0ffee11" in written


def test_what_agents_say_cannot_break_the_svg() -> None:
    evil = '</text><script>alert("1")</script>\x00\ud800\ufffe'
    written = svg(diagram_of([said(0.0, "inform", APP, BASE, content=evil, conversation=evil)]))
    root = ElementTree.fromstring(written.encode())
    assert not list(root.iter(f"{SVG}script"))
    assert any("<script>" in text for text in texts(written))


def test_labels_stay_within_the_picture() -> None:
    talk = [
        said(0.0, "inform", BASE, BASE, content="w" * 200),
        said(0.1, "inform", APP, "a-name-that-is-very-long-indeed@a-robot-that-is-as-long", content="w" * 2000),
    ]
    root = ElementTree.fromstring(svg(diagram_of(talk)))
    width = float(root.attrib["width"])
    for box in root.iter(f"{SVG}rect"):
        if "x" in box.attrib:
            assert float(box.attrib["x"]) >= 0
            assert float(box.attrib["x"]) + float(box.attrib["width"]) <= width
    assert all(len(text) < 1100 for text in texts(svg(diagram_of(talk))))


def texts(written: str) -> list[str]:
    return ["".join(each.itertext()).strip() for each in ElementTree.fromstring(written).iter() if not len(each)]

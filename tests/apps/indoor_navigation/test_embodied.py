"""A component that must know what the robot is, and a base that is slow to say so."""

from collections.abc import Mapping
from typing import Any

from agents.platform.virtual_time import VirtualTimeLoop
from apps.indoor_navigation.algorithms.outline import Outline
from apps.indoor_navigation.component import Role, query_key
from apps.indoor_navigation.components.embodied import SURE, Embodied
from bus import Conversation
from tests.apps.indoor_navigation.site import ROBOT, Site

BODY = {"front": 0.21, "rear": 0.3, "width": 0.42, "limits": {"deceleration": 0.5}}


class Body(Embodied):
    """Only that. told: widths, m, and decelerations, m/s², that it began with."""

    role = Role.REACTIVE

    def __init__(self, name: str, properties: Mapping[str, Any]) -> None:
        super().__init__(name, properties)
        self.told: list[tuple[float, float]] = []

    def embody(self, outline: Outline, deceleration: float) -> None:
        self.told.append((outline.width, deceleration))


def test_a_base_that_is_frozen_is_asked_again_without_a_complaint_until_it_answers() -> None:
    loop = VirtualTimeLoop()
    site = Site(loop)
    asked: list[Conversation] = []
    key = query_key(ROBOT, "robot_base_server", "robot")
    frozen = site.bus.converse(key, lambda arguments, conversation: asked.append(conversation))
    component = Body(f"goto@{ROBOT}", {"asks": {"robot": "robot_base_server"}})
    site.start(component)
    site.run(5.0)
    assert len(asked) > 2
    frozen.close()
    site.bus.serve(key, lambda arguments: dict(BODY))
    site.run(2.0)
    assert component.outline is not None
    assert site.reports == []
    site.close()
    loop.close()


def test_a_robot_that_brakes_less_hard_since_its_gateway_was_restarted_is_known_soon() -> None:
    loop = VirtualTimeLoop()
    site = Site(loop)
    body = dict(BODY)
    site.bus.serve(query_key(ROBOT, "robot_base_server", "robot"), lambda arguments: dict(body))
    component = Body(f"goto@{ROBOT}", {"asks": {"robot": "robot_base_server"}})
    site.start(component)
    site.run(0.1)
    assert component.told == [(0.42, 0.5 * SURE)]
    site.run(2.0)
    assert len(component.told) == 1, "nothing has changed"
    body.update(width=0.6, limits={"deceleration": 0.3})
    site.run(2.0)
    assert component.told[1:] == [(0.6, 0.3 * SURE)]
    assert component.outline is not None
    assert component.outline.width == 0.6
    site.close()
    loop.close()

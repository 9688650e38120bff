"""A component that must know what the robot is, and a base that is slow to say so."""

from agents.platform.virtual_time import VirtualTimeLoop
from apps.indoor_navigation.component import Role, query_key
from apps.indoor_navigation.components.embodied import Embodied
from bus import Conversation
from tests.apps.indoor_navigation.site import ROBOT, Site

BODY = {"front": 0.21, "rear": 0.3, "width": 0.42, "limits": {"deceleration": 0.5}}


class Body(Embodied):
    """Only that."""

    role = Role.REACTIVE


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

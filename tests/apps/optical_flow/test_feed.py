"""What the readings of the robot say, without a robot."""

import pytest

from apps.optical_flow.feed import rear_only


@pytest.mark.parametrize(
    ("front", "rear", "is_rear"),
    [
        ([False, False], [True, False], True),
        ([True, False], [False, False], False),
        ([True, False], [True, False], False),
        ([False, False], [False, False], None),
        ([], [], None),
    ],
)
def test_bumpers_say_where_a_contact_is_and_stalled_wheels_do_not(
    front: list[bool], rear: list[bool], is_rear: bool | None
) -> None:
    assert rear_only({"front": front, "rear": rear, "pressed": True}) is is_rear

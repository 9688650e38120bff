from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from p2os import OdometryUnwrapper, RobotModel, SipCodec, StandardSip
from p2os.odometry import JUMP_COUNTS


def follow(model: RobotModel, path: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """The unwrapped positions of a path that has gone over the wire."""
    codec, unwrapper = SipCodec(model), OdometryUnwrapper(model)
    sips = [codec.decode(codec.encode(StandardSip(x=x, y=y))) for x, y in path]
    return [unwrapper.update(sip.x, sip.y) for sip in sips]


@pytest.mark.parametrize("robot", ["p3dx-sh", "p2dx", "powerbot", "amigo", "p2at"])
@given(
    steps=st.lists(
        st.tuples(st.integers(-JUMP_COUNTS, JUMP_COUNTS), st.integers(-JUMP_COUNTS, JUMP_COUNTS)), max_size=40
    )
)
def test_odometry_is_continuous_when_the_wire_counter_rolls_over(
    model_of: Callable[[str], RobotModel], robot: str, steps: list[tuple[int, int]]
) -> None:
    model = model_of(robot)
    scale = model.scales.distance
    counts = [(0, 0)]
    for dx, dy in steps:
        counts.append((counts[-1][0] + dx, counts[-1][1] + dy))
    path = [(x * scale, y * scale) for x, y in counts]
    for unwrapped, true in zip(follow(model, path), path, strict=True):
        assert unwrapped == pytest.approx(true, abs=1e-9)


def test_the_first_sip_is_the_origin_wherever_the_counter_stands(p3dx: RobotModel) -> None:
    first, second = follow(p3dx, [(5.0, 32.0), (5.1, 33.0)])
    assert first == (0.0, 0.0)
    assert second == pytest.approx((0.1, 1.0))


def test_a_jump_of_the_counter_is_no_movement(p3dx: RobotModel) -> None:
    unwrapper = OdometryUnwrapper(p3dx)
    positions = [unwrapper.update(x, 0.0)[0] for x in (10.0, 10.1, 0.0, 0.1)]  # the counter was reset behind 10.1
    assert positions == pytest.approx([0.0, 0.1, 0.1, 0.2])
    assert unwrapper.jumps == 1


def test_one_false_packet_leaves_no_trace(p3dx: RobotModel) -> None:
    unwrapper = OdometryUnwrapper(p3dx)
    positions = [unwrapper.update(x, 0.0)[0] for x in (1.0, 1.1, 17.0, 1.1, 1.2)]
    assert positions == pytest.approx([0.0, 0.1, 0.1, 0.1, 0.2])


def test_a_counter_known_to_be_set_anew_is_no_movement(p3dx: RobotModel) -> None:
    unwrapper = OdometryUnwrapper(p3dx)
    unwrapper.update(1.0, 1.0)
    unwrapper.update(1.5, 1.0)
    unwrapper.rebase()
    assert unwrapper.update(0.0, 0.0) == pytest.approx((0.5, 0.0))
    assert unwrapper.jumps == 0

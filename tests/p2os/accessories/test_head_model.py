import pytest

from configs import load
from p2os.accessories.head_model import HeadModel


@pytest.mark.parametrize("name", ["vcc4", "evid30"])
def test_lens_magnifies_within_its_ends_whatever_a_head_says(name: str) -> None:
    lens = load(HeadModel, "accessories", name).lens
    assert lens.ratio_at(0) == 1.0
    assert lens.ratio_at(lens.counts) == pytest.approx(lens.ratio)
    assert lens.ratio_at(0xFFFF) == lens.ratio_at(lens.counts)
    assert lens.ratio_at(-5) == 1.0


@pytest.mark.parametrize("name", ["vcc4", "evid30"])
def test_counts_of_the_lens_survive_the_way_over_the_magnification(name: str) -> None:
    lens = load(HeadModel, "accessories", name).lens
    assert all(lens.count_at(lens.ratio_at(count)) == count for count in range(lens.counts + 1))

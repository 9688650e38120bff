from math import radians
from random import Random
from statistics import fmean, pstdev

import pytest

import configs
from p2os_emu.accessories.analog_gyro import AnalogGyro, AnalogGyroSpec


@pytest.fixture
def spec() -> AnalogGyroSpec:
    return configs.load(AnalogGyroSpec, "accessories", "analog-gyro")


def test_a_count_is_worth_what_clients_take_it_for(spec: AnalogGyroSpec) -> None:
    """deg/s = counts x 5 V / 1023 x 300 deg/s / 2.5 V x 1.626. Source: client library."""
    assert spec.deg_s_per_count == pytest.approx(5 / 1023 * 300 / 2.5 * 1.626, abs=1e-6)


def test_turning_left_brings_the_count_below_its_rest(spec: AnalogGyroSpec) -> None:
    gyro = AnalogGyro(spec, Random(1))
    rest = fmean(gyro.sample(0.0, 0.0).rate for _ in range(100))
    left = fmean(gyro.sample(radians(60), 0.0).rate for _ in range(100))
    assert (rest - left) * spec.deg_s_per_count == pytest.approx(60, rel=0.04)


def test_each_gyro_has_its_own_rest_near_the_middle(spec: AnalogGyroSpec) -> None:
    rests = [fmean(AnalogGyro(spec, Random(n)).sample(0.0, 0.0).rate for _ in range(5)) for n in range(100)]
    assert fmean(rests) == pytest.approx(512, abs=2)
    assert pstdev(rests) == pytest.approx(spec.bias_counts, rel=0.3)


def test_the_rest_wanders_as_the_gyro_warms_up(spec: AnalogGyroSpec) -> None:
    drifts = []
    for seed in range(100):
        gyro = AnalogGyro(spec, Random(seed))
        cold = fmean(gyro.sample(0.0, 0.0).rate for _ in range(60))
        warm = fmean(gyro.sample(0.0, 3600.0).rate for _ in range(60))
        drifts.append(warm - cold)
    assert pstdev(drifts) == pytest.approx(spec.bias_counts_per_k * spec.warm_up_k, rel=0.3)
    assert gyro.sample(0.0, 3600.0).temperature > gyro.sample(0.0, 0.0).temperature


def test_counts_end_at_ten_bits(spec: AnalogGyroSpec) -> None:
    gyro = AnalogGyro(spec, Random(1))
    assert gyro.sample(-100.0, 0.0).rate == 1023
    assert gyro.sample(100.0, 0.0).rate == 0


def test_the_same_seed_gives_the_same_gyro(spec: AnalogGyroSpec) -> None:
    first, second = (AnalogGyro(spec, Random(7)) for _ in range(2))
    assert [first.sample(0.1, n) for n in range(50)] == [second.sample(0.1, n) for n in range(50)]

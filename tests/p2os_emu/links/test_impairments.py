"""What distance and noise do to bytes: each stage by itself, with its own seed; time is stepped."""

from collections.abc import Callable
from itertools import pairwise
from random import Random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from p2os_emu.links.impairments import (
    MOST_HELD,
    BitErrors,
    Freeze,
    Impairments,
    Noise,
    Silence,
)
from p2os_emu.links.stage import LinkStage, Rates

RATES = Rates(9600, 9600)
SIP = bytes.fromhex("FA FB 05 32 00 00 32 00")
BYTES = bytes(range(256)) * 400


def stage_of(impairments: Impairments, seed: int) -> LinkStage:
    """The stage of a line with one impairment."""
    (stage,) = impairments.stages(str(seed))
    return stage


def inverted_bits(rate: float, seed: int, count: int) -> list[int]:
    """Which of so many bits, a multiple of eight, arrive inverted."""
    heard = through(BitErrors(rate, Random(seed)), bytes(count // 8))
    return [bit for bit in range(count) if heard[bit // 8] >> bit % 8 & 1]


CHANCY: dict[str, Callable[[int], LinkStage]] = {
    "loss": lambda seed: stage_of(Impairments(loss=0.001, burst_start=5e-3, burst_end=0.05, burst_loss=0.8), seed),
    "bit errors": lambda seed: BitErrors(0.002, Random(seed)),
    "byte damage": lambda seed: stage_of(Impairments(damage=0.01), seed),
    "noise": lambda seed: Noise(Random(seed)),
    "duplication": lambda seed: stage_of(Impairments(duplication=0.5), seed),
    "delay": lambda seed: stage_of(Impairments(jitter=1.0), seed),
}


def through(stage: LinkStage, data: bytes) -> bytes:
    """What leaves a stage at once."""
    return stage.carry(data, 0.0, RATES)


@pytest.mark.parametrize("name", CHANCY)
def test_chance_repeats_with_the_seed_and_differs_with_another(name: str) -> None:
    def happened(seed: int) -> list[bytes]:
        stage = CHANCY[name](seed)
        return [stage.carry(SIP * 3, step / 10, RATES) for step in range(60)]

    assert happened(3) == happened(3)
    assert happened(3) != happened(4)


@pytest.mark.parametrize("name", ["loss", "bit errors", "byte damage"])
@given(cuts=st.lists(st.integers(0, 2000), max_size=30))
def test_how_the_bytes_are_cut_does_not_matter(name: str, cuts: list[int]) -> None:
    whole, pieces = CHANCY[name](1), CHANCY[name](1)
    data, said, start = BYTES[:3000], b"", 0
    for cut in [*sorted(cuts), len(data)]:
        said += through(pieces, data[start:cut])
        start = cut
    assert said == through(whole, data)


@given(st.floats(0.0005, 0.9), st.integers(0, 100))
def test_hits_come_as_often_as_their_rate_says(rate: float, seed: int) -> None:
    count = 20000
    hit = inverted_bits(rate, seed, count)
    assert abs(len(hit) - rate * count) <= 6 * (count * rate * (1 - rate)) ** 0.5 + 1
    assert hit == sorted(set(hit))


@pytest.mark.parametrize(("rate", "expected"), [(0.0, []), (1.0, list(range(8)))])
def test_hits_never_and_always(rate: float, expected: list[int]) -> None:
    assert inverted_bits(rate, 0, 8) == expected


def test_damaged_bytes_are_other_bytes_and_as_many_as_asked_for() -> None:
    heard = through(stage_of(Impairments(damage=1.0), 5), BYTES)
    assert all(was != heard for was, heard in zip(BYTES, heard, strict=True))
    changed = sum(a != b for a, b in zip(BYTES, through(stage_of(Impairments(damage=0.01), 5), BYTES), strict=True))
    assert changed == pytest.approx(0.01 * len(BYTES), rel=0.1)


def test_bit_errors_turn_single_bits_at_the_rate() -> None:
    flips = [(a ^ b).bit_count() for a, b in zip(BYTES, through(BitErrors(0.002, Random(5)), BYTES), strict=True)]
    assert sum(flips) == pytest.approx(0.002 * 8 * len(BYTES), rel=0.1)
    assert max(flips) <= 2


def test_loss_comes_in_bursts_of_the_length_that_was_asked_for() -> None:
    # Source: the two-state channel of Gilbert and Elliott: bursts last 1/burst_end bytes on the average.
    stage = stage_of(Impairments(burst_start=1 / 2000, burst_end=1 / 50), 8)
    kept = [bool(through(stage, b"x")) for _ in range(400_000)]
    lost = kept.count(False)
    bursts = sum(before and not after for before, after in pairwise(kept))
    assert lost / len(kept) == pytest.approx(50 / 2050, rel=0.2)
    assert lost / bursts == pytest.approx(50, rel=0.2)


def test_a_burst_lasts_as_long_on_a_quiet_line_as_on_a_full_one() -> None:
    # At 9600 bit/s 50 bytes pass in 52 ms: of two frames that leave 0.4 s apart, a burst of that length takes one.
    stage = stage_of(Impairments(burst_start=1 / 2000, burst_end=1 / 50), 8)
    kept = [stage.carry(SIP if step % 40 == 0 else b"", step / 100, RATES) for step in range(800_000)][::40]
    lost = [step for step, frame in enumerate(kept) if frame != SIP]
    assert len(lost) / len(kept) == pytest.approx((50 + len(SIP)) / 2050, rel=0.2)
    assert sum(b - a == 1 for a, b in pairwise(lost)) / len(lost) < 0.05


def test_late_bytes_keep_their_order_whatever_the_jitter() -> None:
    stage = stage_of(Impairments(delay=0.05, jitter=0.2), 1)
    arrived = [stage.carry(bytes([step]) if step < 50 else b"", step / 100, RATES) for step in range(100)]
    assert b"".join(arrived) == bytes(range(50))
    assert b"".join(arrived[:5]) == b"", "nothing comes before the delay is over"


def test_delay_without_jitter_is_exact() -> None:
    stage = stage_of(Impairments(delay=0.02), 1)
    assert [stage.carry(data, now, RATES) for data, now in ((b"a", 0.0), (b"", 0.01), (b"", 0.02))] == [b"", b"", b"a"]


def test_duplication_repeats_whole_frames() -> None:
    assert through(stage_of(Impairments(duplication=1.0), 0), SIP + SIP) == SIP * 4


def test_freeze_keeps_what_silence_loses() -> None:
    freeze = Freeze()
    assert through(freeze, SIP) == through(Silence(), SIP) == b""
    assert bytes(freeze.held) == SIP


def test_no_impairment_is_no_stage() -> None:
    assert list(Impairments().stages("seed")) == []


def test_each_number_brings_its_stage() -> None:
    everything = Impairments(0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1)
    kinds = [type(stage) for stage in everything.stages("seed")]
    alone = "duplication", "delay", "loss", "bit_errors", "damage"
    assert kinds == [type(stage_of(Impairments(**{impairment: 0.1}), 0)) for impairment in alone]
    assert len(set(kinds)) == len(alone)


def test_frozen_line_keeps_what_buffers_hold_and_no_more() -> None:
    freeze = Freeze()
    for _ in range(3 * MOST_HELD // 1000):
        assert freeze.carry(bytes(1000), 0.0, Rates(9600, 9600)) == b""
    assert len(freeze.held) == MOST_HELD

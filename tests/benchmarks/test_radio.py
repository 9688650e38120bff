"""The radio benchmark in small: its bookkeeping is exact, and its prediction is what happens."""

import numpy as np
import pytest

from benchmarks import fuzz, radio
from p2os import encode_frame


def test_every_sound_packet_is_used_and_every_count_is_the_injected_one() -> None:
    outcome = radio.run(1200, samples=1)
    assert outcome.sent == 1200
    assert 0 < outcome.used == outcome.intact < outcome.sent
    assert outcome.single > outcome.single_accepted == 0
    assert outcome.miscounted == 0
    assert {"checksum", "noise"} <= set(outcome.counted)
    assert outcome.impossible == outcome.lost_links == 0


def test_prediction_is_what_happens_to_damaged_frames(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(radio, "DAMAGE", 0.05)  # so that a small sample holds enough of them
    frame, rng, tries = encode_frame(bytes(range(29))), np.random.default_rng(3), 300_000
    heard = np.tile(np.frombuffer(frame, np.uint8), (tries, 1))
    damage = rng.integers(1, 256, heard.shape, np.uint8) * (rng.random(heard.shape) < radio.DAMAGE)
    # What the fuzz benchmark would seal a content with, an odd number of bytes and all, is what the checksum should be.
    is_sound = (fuzz.seal_frames((heard ^ damage)[:, 3:-2])[:, -2:] == (heard ^ damage)[:, -2:]).all(axis=1)
    passed = (is_sound & damage.any(axis=1) & ~damage[:, :3].any(axis=1)).sum()
    expected = tries * radio.chance_to_pass(frame)
    assert expected > 50
    assert passed == pytest.approx(expected, abs=4 * expected**0.5)

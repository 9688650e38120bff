"""The noise of the machine: what makes a figure doubtful, and that the figure says it."""

import pytest

from benchmarks.__main__ import main
from benchmarks.figures import Figure, as_text
from benchmarks.headless import Team, factor
from benchmarks.noise import Noise, NoiseMeter


def test_a_quiet_machine_gives_no_doubt() -> None:
    assert Noise(unit=0.4, spread=0.02, others=0.01).doubt == ""


@pytest.mark.parametrize(
    ("noise", "reason"),
    [(Noise(0.4, 0.3, 0.0), "speed varied by 30%"), (Noise(0.4, 0.0, 0.5), "other programs took 50%")],
)
def test_a_noisy_machine_gives_its_reason(noise: Noise, reason: str) -> None:
    assert reason in noise.doubt


def test_noise_is_measured() -> None:
    noise = NoiseMeter().read()
    assert noise.unit > 0.01
    assert noise.spread >= 0.0
    assert 0.0 <= noise.others <= 1.0


def test_a_doubtful_figure_is_marked() -> None:
    figure = Figure("compare", "delay", 1.0, 2.0, "ms", doubt="the processor's speed varied by 30%")
    assert as_text(figure).endswith("NOT TRUSTWORTHY: the processor's speed varied by 30%")
    assert "TRUSTWORTHY" not in as_text(Figure("compare", "delay", 1.0, 2.0, "ms"))


@pytest.mark.parametrize("arguments", [["compare"], ["codec", "--peer-pid", "1"]])
def test_a_comparison_without_a_peer_is_refused(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(arguments)
    assert "--peer HOST:PORT" in capsys.readouterr().err


def test_headless_lasers_scan_ten_times_a_second() -> None:
    team = Team(1)
    team.run(1.0)
    before = team.scanned
    team.run(2.0)
    assert team.scanned - before > 2 * 9 * 181 * 2  # two bytes a beam
    assert factor(1, 0.5) > 0.0

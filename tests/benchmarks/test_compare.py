"""The comparison with another simulator, whose part a second emulator plays."""

from acromovi.children import emulator
from benchmarks.compare import CADENCE, CPU, P50, P99, Side, compare

ROBOT = ("-r", "p3dx-sh", "-p", "0", "-m", "office", "--quiet")


def test_each_metric_has_a_value_and_a_ratio_and_both_a_spread() -> None:
    with emulator(*ROBOT) as ours, emulator(*ROBOT) as peer:
        sides = [Side(each.port, each.process.pid) for each in (ours, peer)]
        figures = compare(sides[0], sides[1], rounds=2, trials=2, cadence_seconds=1.5)
    values = {figure.name: figure for figure in figures if ": ratio" not in figure.name}
    ratios = {figure.name.partition(": ratio")[0]: figure for figure in figures if ": ratio" in figure.name}
    assert values.keys() == {P50, P99, CADENCE, CPU}
    assert {P50, P99, CADENCE} <= ratios.keys()
    assert all(figure.value > 0.0 and figure.samples == 2 for figure in values.values())
    assert all(figure.spread is not None and figure.spread >= 0.0 for figure in figures)


def test_a_peer_whose_process_is_not_known_is_compared_without_processor_time() -> None:
    with emulator(*ROBOT) as ours, emulator(*ROBOT) as peer:
        figures = compare(Side(ours.port, ours.process.pid), Side(peer.port, None), 1, 1, 0.5)
    assert not any(CPU in figure.name for figure in figures)

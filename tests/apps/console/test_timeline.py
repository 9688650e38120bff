"""What has happened: kinds, filters, and what a monitor reports."""

from apps.console.timeline import KINDS, Timeline

ALL = frozenset(KINDS)


def test_events_are_filtered_by_kind_and_by_what_they_are_about() -> None:
    timeline = Timeline(lambda: 5.0)
    timeline.tell("lease", "happy", "console@apps has the lease on the base")
    timeline.tell("fault", "max", "the battery is low")
    assert [event.about for event in timeline.newest(10, ALL)] == ["max", "happy"]
    assert [event.about for event in timeline.newest(10, frozenset({"lease"}))] == ["happy"]
    assert [event.about for event in timeline.newest(10, ALL, "MA")] == ["max"]
    assert len(timeline.newest(1, ALL)) == 1


def test_restarts_and_failures_are_told_by_a_monitor_and_come_in_their_order() -> None:
    timeline = Timeline(lambda: 5.0)
    timeline.tell("console", "page", "begun")
    for at, what, level in (
        (1.0, "base@happy has failed", "warning"),
        (2.0, "base@happy has been started again", "ok"),
    ):
        timeline.hear_monitor({"time": at, "what": what, "about": "base@happy", "level": level})
    timeline.hear_monitor({"time": 3.0, "what": "the gateway of happy has come", "about": "happy", "level": "ok"})
    timeline.hear_monitor({"time": "x"})
    assert [(event.kind, event.time) for event in timeline.newest(9, ALL)] == [
        ("console", 5.0),
        ("restart", 2.0),
        ("restart", 1.0),
    ]

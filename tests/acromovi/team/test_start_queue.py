"""Programs start a few at a time."""

from acromovi.team.plan import PlannedProcess, ProcessKind
from acromovi.team.processes import StartQueue

A, B, C = (PlannedProcess(name, ProcessKind.GATEWAY, ("true",)) for name in "abc")


def test_programs_begin_in_order_and_only_so_many_at_once() -> None:
    begun: list[PlannedProcess] = []
    queue = StartQueue(begun.append, at_once=2)
    for program in (A, B, C):
        queue.add(program)
    assert begun == [A, B]
    queue.has_started(B)
    assert begun == [A, B, C]


def test_program_begins_once_however_often_it_is_added_or_starts() -> None:
    begun: list[PlannedProcess] = []
    queue = StartQueue(begun.append, at_once=1)
    queue.add(A)
    queue.has_started(A)
    queue.add(A)
    queue.has_started(A)
    queue.add(B)
    assert begun == [A, B]

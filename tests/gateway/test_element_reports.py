"""What a person is told of lasers, arms and cameras."""

from collections.abc import Callable

from gateway.cables.camera_thread import CameraThread
from gateway.link_diagnosis import ELEMENT_PATIENCE, ElementReports


def camera(clock: Callable[[], float] = lambda: 0.0) -> CameraThread:
    thread = CameraThread("http://camera/video")
    thread.driver = type(thread.driver)(clock)
    return thread


def test_element_that_never_answers_is_told_once_and_with_the_reason() -> None:
    element = camera()
    reports = ElementReports([element])
    element.driver.lose("camera does not answer: refused")
    assert not [*reports.due(0.0), *reports.due(ELEMENT_PATIENCE - 0.1)]
    [first] = reports.due(ELEMENT_PATIENCE)
    assert first == ("camera", False, False, ("the camera gives no pictures: camera does not answer: refused",))
    assert not list(reports.due(2 * ELEMENT_PATIENCE))


def test_element_that_answers_is_found_lost_and_found_again() -> None:
    element = camera()
    reports = ElementReports([element])
    element.driver.take((4, 3))
    assert [each.answers for each in reports.due(0.0)] == [True]
    element.driver.lose("gone")
    [lost] = reports.due(0.1)
    assert (lost.answers, lost.has_answered) == (False, True)
    element.driver.take((4, 3))
    assert [each.answers for each in reports.due(0.2)] == [True]
    assert not list(reports.due(100.0))


def test_element_that_answers_late_is_found_all_the_same() -> None:
    element = camera()
    reports = ElementReports([element])
    assert not list(reports.due(5.0))
    assert len(list(reports.due(5.0 + ELEMENT_PATIENCE))) == 1
    element.driver.take((4, 3))
    assert list(reports.due(6.0 + ELEMENT_PATIENCE)) == [("camera", True, True, ())]

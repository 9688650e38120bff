"""What a person is told of lasers, arms and cameras."""

from collections.abc import Callable

from gateway.cables.camera_thread import CameraThread
from gateway.element_news import PATIENCE, ElementChange, ElementNews


def camera(clock: Callable[[], float] = lambda: 0.0) -> CameraThread:
    thread = CameraThread("http://camera/video")
    thread.driver = type(thread.driver)(clock)
    return thread


def test_element_that_never_answers_is_told_once_and_with_the_reason() -> None:
    element = camera()
    news = ElementNews([element])
    element.driver.lose("camera does not answer: refused")
    assert not [*news.since(0.0), *news.since(PATIENCE - 0.1)]
    [first] = news.since(PATIENCE)
    assert first == ElementChange(
        "camera", False, False, ("the camera gives no pictures: camera does not answer: refused",)
    )
    assert not list(news.since(2 * PATIENCE))


def test_element_that_answers_is_found_lost_and_found_again() -> None:
    element = camera()
    news = ElementNews([element])
    element.driver.take((4, 3))
    assert [each.answers for each in news.since(0.0)] == [True]
    element.driver.lose("gone")
    [lost] = news.since(0.1)
    assert (lost.answers, lost.has_been) == (False, True)
    element.driver.take((4, 3))
    assert [each.answers for each in news.since(0.2)] == [True]
    assert not list(news.since(100.0))


def test_element_that_answers_late_is_found_all_the_same() -> None:
    element = camera()
    news = ElementNews([element])
    assert not list(news.since(5.0))
    assert len(list(news.since(5.0 + PATIENCE))) == 1
    element.driver.take((4, 3))
    assert list(news.since(6.0 + PATIENCE)) == [ElementChange("camera", True, True, ())]

"""The bridge, as far as it is more than what the end-to-end tests show."""

import os
import threading
from collections.abc import Callable

import pytest

from gateway.bridge import Bridge
from gateway.driver import Driver
from gateway.errors import PortLost
from gateway.serial_port import Port
from p2os import Identity, RobotModel


def _no_model(identity: Identity) -> RobotModel:
    raise AssertionError("nobody answers")


def _no_port() -> Port:
    raise PortLost("there is no port")


@pytest.mark.parametrize("wake", [Bridge.wake, Bridge.stop])
def test_bridge_that_is_closed_wakes_nobody_else(wake: Callable[[Bridge[Driver]], None]) -> None:
    bridge = Bridge(Driver(_no_model, [9600]), None, _no_port)
    bridge.close()
    bridge.close()  # once is enough
    reader, writer = os.pipe()  # most likely they take the numbers that the bridge gave back
    try:
        os.set_blocking(reader, False)
        wake(bridge)
        with pytest.raises(BlockingIOError):
            os.read(reader, 1)
    finally:
        os.close(reader)
        os.close(writer)


def test_threads_may_wake_a_bridge_while_it_is_closed() -> None:
    bridge = Bridge(Driver(_no_model, [9600]), None, _no_port)
    errors: list[BaseException] = []

    def wake() -> None:
        try:
            for _ in range(2000):
                bridge.wake()
        except BaseException as error:  # of any kind: the test asks for none
            errors.append(error)

    threads = [threading.Thread(target=wake) for _ in range(4)]
    for thread in threads:
        thread.start()
    bridge.close()
    for thread in threads:
        thread.join()
    assert errors == []

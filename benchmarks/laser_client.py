"""A plain host of an LMS 2xx on a pty, for measuring: it sets the laser up and counts scans."""

import os
import select
import termios
import time
from typing import Self

from benchmarks.client import TCP, open_port
from p2os.accessories.lms import MODE_OF_BAUD, LmsAnswerCode, LmsMode, LmsRequestCode, Variant
from p2os.accessories.lms_framing import LmsTelegram, LmsTelegramDecoder, encode

ANSWER_TIMEOUT_S = 2.0
SETTLE_S = 0.2


class LaserPortClient:
    """Holds the laser's port open; use it as a context manager.

    descriptor: to wait on. scans: how many have come.
    """

    def __init__(self, port: str) -> None:
        self.descriptor = open_port(port)
        self._has_rate = not port.startswith(TCP)
        self._set_rate(9600)
        self.scans = 0
        self._decoder = LmsTelegramDecoder(from_laser=True)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        os.close(self.descriptor)

    def start(self, baud: int, variant: Variant) -> None:
        """Bring the laser to a rate, bit/s, and to its beams, and let it scan without end.

        Raises:
            TimeoutError: It does not answer.
        """
        self._ask(LmsRequestCode.MODE, bytes((LmsMode.ON_REQUEST,)), LmsAnswerCode.MODE)
        self._ask(LmsRequestCode.MODE, bytes((MODE_OF_BAUD[baud],)), LmsAnswerCode.MODE)
        self._set_rate(baud)
        time.sleep(SETTLE_S)
        self._ask(LmsRequestCode.VARIANT, variant.pack(), LmsAnswerCode.VARIANT)
        self._ask(LmsRequestCode.MODE, bytes((LmsMode.CONTINUOUS,)), LmsAnswerCode.MODE)

    def read(self) -> list[LmsTelegram]:
        """Every telegram that is complete with the bytes that wait."""
        data = os.read(self.descriptor, 4096)
        found = self._decoder.receive(data, time.monotonic())
        telegrams = [each for each in found if isinstance(each, LmsTelegram)]
        self.scans += sum(each.code == LmsAnswerCode.SCAN for each in telegrams)
        return telegrams

    def listen(self, seconds: float) -> None:
        """Count scans for a while."""
        deadline = time.monotonic() + seconds
        while (rest := deadline - time.monotonic()) > 0:
            if select.select([self.descriptor], [], [], rest)[0]:
                self.read()

    def _set_rate(self, baud: int) -> None:
        if not self._has_rate:
            return
        attributes = termios.tcgetattr(self.descriptor)
        attributes[4] = attributes[5] = getattr(termios, f"B{baud}")
        termios.tcsetattr(self.descriptor, termios.TCSANOW, attributes)

    def _ask(self, request: LmsRequestCode, data: bytes, answer: LmsAnswerCode) -> None:
        os.write(self.descriptor, encode(request, data))
        deadline = time.monotonic() + ANSWER_TIMEOUT_S
        while (rest := deadline - time.monotonic()) > 0:
            if select.select([self.descriptor], [], [], rest)[0] and any(each.code == answer for each in self.read()):
                return
        raise TimeoutError(f"the laser did not answer {request.name} in {ANSWER_TIMEOUT_S} s")

"""`p2os-emu`: emulated robots on ports of their own."""

import os
import signal
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from types import FrameType
from typing import NoReturn

from configs import ConfigError
from configs.startup import uncollected
from p2os_emu.fault_spec import FaultError
from p2os_emu.links.link import PortError
from p2os_emu.options import EXIT_CONFIG, EXIT_OK, EXIT_PHYSICS, EXIT_PORT, PhysicsError, parse

_ENDINGS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


def main(argv: Sequence[str] | None = None) -> int:
    """Parse, build and run; returns an exit code of `p2os_emu.options`."""
    try:
        options = parse(argv)
        if options.listing is not None:
            from p2os_emu.lists import listing

            print(listing(options.listing), flush=True)
            return EXIT_OK
        with _ended_by_signals():
            with uncollected():  # here and not at the top: who asks for help or mistypes an option need not wait for it
                from p2os_emu.emulation import run
            return run(options)
    except (ConfigError, FaultError) as error:
        return _fail(error, EXIT_CONFIG)
    except PortError as error:
        return _fail(error, EXIT_PORT)
    except PhysicsError as error:
        return _fail(error, EXIT_PHYSICS)
    except BrokenPipeError:
        # Whoever was to read this is gone, and so is the reason to go on. What is still buffered goes nowhere.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return EXIT_OK


def _fail(error: Exception, code: int) -> int:
    print(f"p2os-emu: {error}", file=sys.stderr)
    return code


@contextmanager
def _ended_by_signals() -> Iterator[None]:
    """SIGINT, SIGTERM and SIGHUP end what is inside, in order: links, sockets and folders are removed."""
    before = {number: signal.signal(number, _leave) for number in _ENDINGS}
    try:
        yield
    except _EndSignal:  # that is how it ends
        return
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


class _EndSignal(BaseException):
    """A signal ended the program; derived from BaseException, so that no handler of errors catches it."""


def _leave(number: int, frame: FrameType | None) -> NoReturn:
    # A second signal must not interrupt the tidying up.
    for each in _ENDINGS:
        signal.signal(each, signal.SIG_IGN)
    raise _EndSignal


if __name__ == "__main__":
    sys.exit(main())

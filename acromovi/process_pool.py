"""Processes that share work: each on one core, and none outlives the command that began it."""

import multiprocessing
import os
import threading
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager


@contextmanager
def process_pool(count: int | None = None) -> Iterator[ProcessPoolExecutor]:
    """Share work between so many processes; by default one for each core.

    The block waits for all of it. Where it ends early, as by Ctrl-C or SIGTERM, the processes are ended at once, and
    they end by themselves if this one is killed.
    """
    # In each process, numpy's linear algebra would have a thread for each core spin.
    for library in ("OPENBLAS", "OMP", "MKL"):
        os.environ.setdefault(f"{library}_NUM_THREADS", "1")
    spawn = multiprocessing.get_context("spawn")  # a copy of a process with threads may hang
    before = set(multiprocessing.active_children())
    with ProcessPoolExecutor(count or os.cpu_count(), spawn, _begin) as pool:
        try:
            yield pool
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            for process in set(multiprocessing.active_children()) - before:
                process.kill()
            raise


def _begin() -> None:
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    assert parent is not None  # this process was begun by another one
    parent.join()
    os._exit(1)  # nobody is there to take the results

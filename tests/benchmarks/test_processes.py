"""What benchmarks read of other processes."""

import subprocess
import sys

import pytest

from benchmarks.processes import cpu_seconds

COUNT = "for number in range({}): pass\nprint(__import__('time').process_time(), flush=True)\ninput()"


@pytest.mark.parametrize("steps", [1, 2_000_000])
def test_processor_time_of_another_process_is_what_it_says_itself(steps: int) -> None:
    command = [sys.executable, "-c", COUNT.format(steps)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        own = float(process.stdout.readline())
        seen = cpu_seconds(process.pid)
        process.communicate("\n")
    assert 0.0 < own <= seen < own + 0.1


def test_a_process_that_does_not_exist_has_no_processor_time() -> None:
    with subprocess.Popen([sys.executable, "-c", ""]) as process:
        process.wait()
    with pytest.raises(OSError, match="Invalid argument"):
        cpu_seconds(process.pid)

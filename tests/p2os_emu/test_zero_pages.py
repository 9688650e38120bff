"""Memory that the engine has filled with zeros is given back, and nothing else."""

import mmap
import platform
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from p2os_emu.program import emulator

pytestmark = pytest.mark.skipif(
    platform.libc_ver()[0] != "glibc", reason="memory is given back on Linux with glibc only"
)

LARGE = 4 * 2**20  # bytes
MOST_MB = 8.0  # the engine's buffers of zeros are 16 MB
PROBE = """
import ctypes
import mmap

from p2os_emu.zero_pages import zeros_given_back

SIZE = 64 * 2**20
STEP = 100 * mmap.PAGESIZE


def held():
    with open("/proc/self/status") as status:
        rows = dict(line.split(":", 1) for line in status)
    return int(rows["RssAnon"].split()[0]) // 1024


allocate = ctypes.CDLL(None).malloc
allocate.argtypes, allocate.restype = [ctypes.c_size_t], ctypes.c_void_p
before = held()
with zeros_given_back():
    begin = allocate(SIZE)
    ctypes.memset(begin, 0, SIZE)
    block = (ctypes.c_ubyte * SIZE).from_address(begin)
    for place in range(7, SIZE, STEP):
        block[place] = 1 + place % 251
    full = held() - before
left = held() - before
assert full >= 60, full
assert left <= 10, left
assert {place: byte for place, byte in enumerate(bytes(block)) if byte} == {
    place: 1 + place % 251 for place in range(7, SIZE, STEP)
}
ctypes.memset(begin, 5, SIZE)
assert set(bytes(block)) == {5}
"""


def test_pages_of_zeros_are_given_back_and_all_bytes_are_as_before() -> None:
    # Not checked here, so that what it complains of is shown.
    done = subprocess.run([sys.executable, "-c", PROBE], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")


def zeros_held(pid: int) -> float:
    """Return how much of the memory that a process holds in large mappings of its own is pages of zeros, MB."""
    count, files = 0, Path(f"/proc/{pid}")
    with (
        (files / "maps").open(encoding="utf-8") as maps,
        (files / "mem").open("rb") as memory,
        (files / "pagemap").open("rb") as table,
    ):
        for line in maps:
            addresses, permissions, _, _, inode, *name = line.split()
            begin, end = (int(each, 16) for each in addresses.split("-"))
            if permissions != "rw-p" or inode != "0" or name or end - begin < LARGE:
                continue
            table.seek(begin // mmap.PAGESIZE * 8)
            entries = np.frombuffer(table.read((end - begin) // mmap.PAGESIZE * 8), np.uint64)
            for page in np.flatnonzero(entries >> np.uint64(63)).tolist():  # the highest bit: it is held
                memory.seek(begin + page * mmap.PAGESIZE)
                count += not any(memory.read(mmap.PAGESIZE))
    return count * mmap.PAGESIZE / 2**20


def test_an_emulator_holds_no_buffers_of_zeros() -> None:
    with emulator("--robot", "p3dx-sh", "--world", "office", "--quiet") as robots:
        try:
            held = zeros_held(robots.process.pid)
        except PermissionError as err:  # as where only a parent may look into a process (Yama)
            pytest.skip(f"the memory of a process cannot be read here: {err.strerror}")
    assert held < MOST_MB

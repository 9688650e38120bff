"""Gives memory that holds only zeros back to the system.

The engine fills two buffers of 8 MB with zeros when a world is opened, and an emulator never uses them. A page that was
given back is zeros again for the first who reads it, so nothing changes but the memory that is held.

Only blocks that the C library has mapped by themselves are looked through: no object of Python is in them, so what this
module allocates meanwhile cannot be in a page that it gives back.
"""

import ctypes
import mmap
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

_MAPPINGS = Path("/proc/self/maps")
_LEAST = 4 * 2**20  # bytes of a block that is looked through
_WORDS = mmap.PAGESIZE // 8  # of a page
_FLAGS, _MAPPED_BY_ITSELF = 7, 2  # of the size before a block (glibc, malloc/malloc.c)
_DONTNEED = 4  # advice of madvise(2): the pages are given back at once


@contextmanager
def zeros_given_back() -> Iterator[None]:
    """Give back the zeros in large blocks of memory that were allocated in the block; with Linux and glibc only.

    Only for a process in which no other thread writes to memory meanwhile.
    """
    before = set(_mappings())
    yield
    for begin, end in set(_mappings()) - before:
        held = memoryview((ctypes.c_char * (end - begin)).from_address(begin))
        pages = np.frombuffer(held, np.uint64).reshape(-1, _WORDS)
        for first, after in _blocks(pages):
            _give_back(begin + first * mmap.PAGESIZE, pages[first:after])


def _mappings() -> Iterator[tuple[int, int]]:
    """Yield begin and end of the large mappings of memory that belong to no file."""
    if sys.platform != "linux":
        return
    # Names of files may be in any encoding; they are not read.
    for line in _MAPPINGS.read_text(encoding="utf-8", errors="replace").splitlines():
        addresses, permissions, _, _, inode, *name = line.split(maxsplit=5)
        begin, end = (int(address, 16) for address in addresses.split("-"))
        if permissions == "rw-p" and inode == "0" and not name and end - begin >= _LEAST:
            yield begin, end


def _blocks(pages: NDArray[np.uint64]) -> Iterator[tuple[int, int]]:
    """Yield first page and page after the last of each large block; pages: 64-bit words, shape (n, 512).

    Mappings beside each other are one for the system. The size of a block, with its flags, is the second word of its
    first page, and the first word is zero.
    """
    is_begin = (pages[:, 0] == 0) & (pages[:, 1] & _FLAGS == _MAPPED_BY_ITSELF)
    sizes = np.where(is_begin, pages[:, 1] - _MAPPED_BY_ITSELF, 0)
    for first in np.flatnonzero(sizes >= _LEAST).tolist():
        after = first + int(sizes[first]) // mmap.PAGESIZE
        if after <= len(pages):
            yield first, after


def _give_back(begin: int, pages: NDArray[np.uint64]) -> None:
    """Give back those pages of a block, which begins at an address, that hold only zeros."""
    is_zero = ~pages.any(axis=1)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], is_zero, [False]]))).reshape(-1, 2)
    advise = ctypes.CDLL(None).madvise
    advise.argtypes = ctypes.c_void_p, ctypes.c_size_t, ctypes.c_int
    for first, after in edges.tolist():
        # Where it is refused, the memory stays held, and that is all.
        advise(begin + first * mmap.PAGESIZE, (after - first) * mmap.PAGESIZE, _DONTNEED)

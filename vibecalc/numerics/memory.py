"""Memory that the allocator keeps for the next array instead of handing it back to the system."""

import numpy as np

#: bytes of an array from which on memory is still taken from the system and handed back
KEPT = 1 << 24


def keep_freed_memory() -> None:
    """Let arrays of up to 16 MB be made in memory that arrays before them have left.

    A page that the system hands out anew costs more than the arithmetic on the numbers in it.
    glibc keeps what is freed up to twice the size of the largest piece that was ever handed back,
    which this makes and frees without touching it; other allocators take no notice.
    """
    np.empty(KEPT, dtype=np.uint8)

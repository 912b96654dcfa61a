"""Compilation of kernels: by numba when first called, cached on disk, with numpy's rules for division."""

from collections.abc import Callable
from functools import cache, partial
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
from numba import njit

# Types of numbers in kernels; an unsigned index needs no branch for those that count from an array's end.
unsigned, whole, real = np.uint64, np.int64, np.float64


def compiled(function: Callable[..., Any], **more: bool) -> Any:
    """`function` compiled when first called and cached on disk, or in memory if no folder can be written.

    It releases the interpreter's lock, so that blocks may run in threads. more : further options of numba.
    """
    options: Any = {"nogil": True, "error_model": "numpy", "no_cfunc_wrapper": True, **more}
    try:
        made: Any = njit(**{"cache": True} | options)(function)
    except RuntimeError:  # numba found no folder for its cache
        return njit(**options)(function)
    if hasattr(made._cache, "_cache_file"):  # inlined functions have none
        # numba checks only a kernel's own file for changes, but kernels call functions of other files: so
        # each version of all sources has cache files of its own
        file: Any = made._cache._cache_file
        base = file._index_name.removesuffix(".nbi")
        file.__init__(file._cache_path, f"{base}-{sources()[:12]}", file._source_stamp)
    return made


# As `compiled`, for what allocates nothing: counting references takes 5 ns at each use of an array in a tuple.
entry = partial(compiled, _nrt=False)
# As `entry`, for functions that only kernels call: wrappers for Python take a third of the compiler's time.
bare = partial(entry, no_cpython_wrapper=True)
# As `bare`, for short functions that become a part of each kernel that calls them.
inlined = partial(bare, cache=False, forceinline=True)


@cache
def sources() -> str:
    """Hash of all sources of kernels, which identifies their version."""
    here = Path(__file__).parent
    folders = here, here.parent / "origins" / "laws"
    files = [file for folder in folders for file in sorted(folder.rglob("*.py"))]
    return sha256(b"".join(file.read_bytes() for file in files)).hexdigest()


# the same bits as another type of number
bits_of = inlined(lambda x: np.float64(x).view(np.int64))
double_of = inlined(lambda x: np.int64(x).view(np.float64))
# the nearest whole number
rounded = inlined(lambda x: np.int64(np.floor(x + 0.5)))

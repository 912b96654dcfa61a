"""How kernels are compiled: by numba when first called, and kept on disk."""

from collections.abc import Callable
from typing import Any

from numba import njit


def compiled(function: Callable[..., Any]) -> Any:
    """`function` compiled when first called and kept on disk; in memory only where no folder can be written."""
    try:
        return njit(cache=True)(function)
    except RuntimeError:  # numba found no folder for its cache
        return njit(function)

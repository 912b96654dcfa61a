"""How kernels are compiled: by numba when first called, kept on disk, and with numpy's rules for division."""

from collections.abc import Callable
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Any

from numba import njit, types
from numba.extending import intrinsic

_HERE = Path(__file__).parent
_ORIGINS = ("hot_cells", "quantile", "streams")  # whose constants are compiled in


def compiled(function: Callable[..., Any], **options: Any) -> Any:
    """`function` compiled when first called and kept on disk; in memory only where no folder can be written."""
    try:
        made: Any = njit(cache=True, error_model="numpy", **options)(function)
    except RuntimeError:  # numba found no folder for its cache
        return njit(error_model="numpy", **options)(function)
    # numba compares a kernel's own file alone with what is on disk; it calls others, in other files
    file = made._cache._cache_file
    file._source_stamp = file._source_stamp, sources()
    return made


def bare(function: Callable[..., Any]) -> Any:
    """`compiled` for a function that allocates nothing: numba then counts no references, which costs several ns each
    time an array in a NamedTuple is used. Threads may run it side by side."""
    return compiled(function, nogil=True, _nrt=False)


@cache
def sources() -> str:
    """What tells these kernels from those of another version."""
    files = [*sorted(_HERE.rglob("*kernel.py")), *(_HERE.parent / f"origins/{name}.py" for name in _ORIGINS)]
    return sha256(b"".join(file.read_bytes() for file in files)).hexdigest()


inlined = njit(inline="always")


def _bitcast(source: Any, target: Any) -> Any:
    @intrinsic
    def cast(typing_context, value):  # type: ignore[no-untyped-def]
        def generate(context, builder, signature, arguments):  # type: ignore[no-untyped-def]
            return builder.bitcast(arguments[0], context.get_value_type(target))

        return target(source), generate

    return cast


bits_of = _bitcast(types.float64, types.int64)
double_of = _bitcast(types.int64, types.float64)
single_of = _bitcast(types.int32, types.float32)

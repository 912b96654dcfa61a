"""Convolution of causal lattice sequences, and the renewal equation on them, by fast Fourier transforms."""

import numpy as np
import numpy.typing as npt
from scipy.fft import irfft, next_fast_len, rfft

Array = npt.NDArray[np.float64]

_DAMPING = 1e-10


def convolve(first: Array, second: Array, size: int) -> Array:
    """First `size` terms of the causal convolution of two sequences."""
    first, second = first[:size], second[:size]
    length = next_fast_len(first.size + second.size - 1, real=True)
    return irfft(rfft(first, length) * rfft(second, length), length)[:size]


def renew(source: Array, kernel: Array, release: Array) -> tuple[Array, Array]:
    """Sequence b with b = source + kernel * b, and release * b; all four of one size.

    Terms are damped by r^j so that what wraps round a transform twice too long is 1e-10 of the rest; the division is
    then exact but for that and for round-off, which the undamping enlarges. The residual of the first answer, solved
    for in the same way, takes both away.
    """
    size = source.size
    length = next_fast_len(2 * size, real=True)
    damping = np.exp(np.log(_DAMPING) / length * np.arange(size))
    undamping = 1.0 / damping
    inverse = 1.0 / (1.0 - rfft(kernel * damping, length))

    def divide(right: Array) -> Array:
        return irfft(rfft(right * damping, length) * inverse, length)[:size] * undamping

    breaks = divide(source)
    breaks += divide(source - breaks + irfft(rfft(kernel, length) * rfft(breaks, length), length)[:size])
    return breaks, irfft(rfft(release, length) * rfft(breaks, length), length)[:size]

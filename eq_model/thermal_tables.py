"""What the kernels need of thermal breaking, tabulated: Dawson's integral and its growth, and what contacts bear."""

from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.special import dawsn

from eq_model.compiled_table import kernel_table
from origins import SoftRates, StiffRates
from origins.dawson import inverse_log_growth
from origins.errors import InputError
from origins.quantile import QuantileTable, quantile_table
from origins.thermal import GivenRates, Thermal

Array = npt.NDArray[np.float64]

_KINDS = {SoftRates: 1, StiffRates: 2}  # as thermal_kernel numbers them
_STEP = 1.0 / 128.0
_OCTAVES = 80  # levels up to 1e24 k_BT: those of the coldest contacts there may be, at 100 times the mean threshold


class LogBearing:
    """ln e, e of the exponential law of mean 1: a contact breaks where the integral of its rate comes to e."""

    breakpoints = np.empty(0)

    def cdf(self, x: npt.ArrayLike) -> Array:
        """Probability of at most x."""
        return -np.expm1(-np.exp(x))

    def sf(self, x: npt.ArrayLike) -> Array:
        """Probability of more than x."""
        return np.exp(-np.exp(x))

    def ppf(self, q: npt.ArrayLike) -> Array:
        """The x below which a part q lies."""
        return np.log(-np.log1p(-np.asarray(q, dtype=float)))

    def isf(self, q: npt.ArrayLike) -> Array:
        """The x above which a part q lies."""
        return np.log(-np.log(q))


@cache
def growth_tables() -> tuple[float, Array, Array, float, Array, Array]:
    """Dawson's integral and the inverse of its growth, each as step, values and slopes on thermal_kernel's nodes."""
    y = _STEP * np.arange(12 * 128 + 1)
    inverse = inverse_log_growth(-4.0 + _STEP * np.arange(40 * 128 + 1))
    return _STEP, dawsn(y), 1.0 - 2.0 * y * dawsn(y), _STEP, inverse, dawsn(inverse)


@cache
def bearing_table() -> QuantileTable:
    """Quantiles of the logarithm of what contacts bear."""
    return quantile_table(LogBearing(), name="what contacts bear")


@cache
def _soft_cells() -> Array:
    """Cubics of the inverse growth in cells of an octave's 256th of level + ABOVE."""
    from eq_model.thermal_kernel import ABOVE, CELL_BITS

    many = 1 << CELL_BITS
    octave = np.repeat(2.0 ** np.arange(_OCTAVES), many)
    begin = octave * np.tile(1.0 + np.arange(many) / many, _OCTAVES)
    width = octave / many
    low, high = inverse_log_growth(begin - ABOVE), inverse_log_growth(begin + width - ABOVE)
    first, last, rise = dawsn(low) * width, dawsn(high) * width, high - low
    return np.stack([low, first, 3.0 * rise - 2.0 * first - last, first + last - 2.0 * rise], axis=-1)


def law_for_kernel(thermal: Thermal | GivenRates | None, unit: float) -> tuple[int, float, float]:
    """Kind, a and rate, in units of the lattice. Raises InputError for a rate law that the kernels do not know."""
    if thermal is None:
        return 0, 0.0, 0.0
    kind = next((kind for law, kind in _KINDS.items() if type(thermal.rates) is law), None)
    if kind is None:
        raise InputError(f'thermal: the ensemble does not know the rate law "{thermal.law}" yet')
    return kind, unit / np.sqrt(2.0 * thermal.temperature), thermal.attempt_frequency


def steady_for_kernel(thermal: Thermal | GivenRates | None, velocity: float, unit: float) -> tuple[Any, ...]:
    """Breaking in steady forward motion, for many contacts at once; as kernel.run takes it."""
    from eq_model.thermal_kernel import ABOVE, LEVEL_UNIT, SOFT

    law = law_for_kernel(thermal, unit)
    kind, a, rate = law
    table = kernel_table(bearing_table(), LEVEL_UNIT)
    cells = np.zeros((1, 4))
    constant, log_speed = 0.0, float(np.log(velocity / unit))
    if kind:
        constant = log_speed - float(np.log(rate))
        constant += float(np.log(a)) + ABOVE if kind == SOFT else float(np.log(1.5 * a * a))
    if kind == SOFT:
        cells = _soft_cells()
    return kind, constant, a, cells, table, law, growth_tables(), log_speed

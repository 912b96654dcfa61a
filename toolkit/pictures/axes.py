"""Axes that can be read: lengths in metres with a prefix, densities that peak or span decades."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from toolkit.results.records import ThresholdCurve

if TYPE_CHECKING:
    from matplotlib.axis import Axis

INK = {"master": "#1f4e79", "eq": "#c0392b", "thresholds": "#2e7d32"}
_DECADES = 1e3  # a quantity that spans more is drawn on a logarithmic axis
_SPIKE = 10.0  # times what 95 % of the contacts see: a higher end of a density is cut off
_SHARE = 0.05  # of the contacts, above and below what the limits are made for


def plain(text: str) -> str:
    """`text` as matplotlib shows it: what is no formula, though it has dollars, letter by letter."""
    from matplotlib.mathtext import MathTextParser

    try:
        MathTextParser("agg").parse(text)
    except ValueError:
        return text.replace("\\$", "$").replace("$", r"\$")
    return text


def name_lengths(axis: "Axis", name: str, metres: bool) -> None:
    """Label an axis of lengths; ticks in metres have a prefix, such as 25 nm."""
    from matplotlib.ticker import EngFormatter

    axis.set_label_text(name)
    if metres:
        axis.set_major_formatter(EngFormatter(unit="m"))


@dataclass(frozen=True)
class Heights:
    """Limits for a density: bottom and top, and whether the axis is logarithmic between them."""

    bottom: float
    top: float
    logarithmic: bool


def heights(curve: ThresholdCurve, values: Any) -> Heights:
    """Limits that show `values` over curve.x: what 5 % of the contacts or more see of them.

    A spike at an end of the law, where a density diverges, is cut off; other peaks are shown however narrow.
    """
    values = np.asarray(values, dtype=float)
    shown = np.isfinite(values) & (values > 0.0)
    weight, seen = -np.diff(curve.survival, append=0.0)[shown], values[shown]
    if not seen.size or not weight.sum() > 0.0:
        return Heights(0.0, float(seen.max(initial=1.0)), False)
    order = np.argsort(seen)
    sums = np.cumsum(weight[order]) / weight.sum()
    low, high = seen[order][np.searchsorted(sums, [_SHARE, 1.0 - _SHARE])].tolist()
    top = float(seen.max())
    if high > _DECADES * low:
        return Heights(low / 10.0, high * 10.0, True)
    at_end = int(np.argmax(seen)) in (0, seen.size - 1)
    return Heights(0.0, 1.5 * high if top > _SPIKE * high and at_end else 1.05 * top, False)


def spans_decades(curve: ThresholdCurve) -> bool:
    """Whether half of the thresholds lie in the first thousandth of what is shown."""
    median, last = (float(curve.x[curve.survival > part].max(initial=0.0)) for part in (0.5, 1e-3))
    return 0.0 < median * _DECADES < last

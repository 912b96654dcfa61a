"""Axes that can be read: lengths with the prefix of their unit, densities that peak or span decades."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from toolkit.results.records import ThresholdCurve

if TYPE_CHECKING:
    from matplotlib.axis import Axis

INK = {"master": "#1f4e79", "eq": "#c0392b", "thresholds": "#2e7d32"}
_PREFIXES = {-12: "pm", -9: "nm", -6: "µm", -3: "mm", 0: "m"}
_PLAIN = (-2, 4)  # powers of ten of a number that is written out
_DECADES = 1e3  # a quantity that spans more is drawn on a logarithmic axis
_SPIKE = 10.0
_SHARE = 0.05


def plain(text: str) -> str:
    """`text` as matplotlib shows it: what is no formula, though it has dollars, letter by letter."""
    from matplotlib.mathtext import MathTextParser

    try:
        MathTextParser("agg").parse(text)
    except ValueError:
        return text.replace("\\$", "$").replace("$", r"\$")
    return text


@dataclass(frozen=True)
class Lengths:
    """How lengths up to some size are written: in units of 10^power, whose name, for metres, is `prefixed`."""

    power: int
    prefixed: str

    @classmethod
    def of(cls, largest: float, metres: bool) -> "Lengths":
        """Numbers from 1 to 1000: always for metres, for other units where the numbers would be long."""
        order = int(np.floor(np.log10(largest))) if 0.0 < largest < np.inf else 0
        if metres:
            power = min(max(3 * (order // 3), min(_PREFIXES)), max(_PREFIXES))
            return cls(power, _PREFIXES[power])
        return cls(0 if _PLAIN[0] <= order < _PLAIN[1] else 3 * (order // 3), "")

    def write(self, axis: "Axis", name: str) -> None:
        """Label and tick labels of an axis of lengths; the data stay as they are."""
        self._write(axis, name, self.prefixed, self.power)

    def write_inverse(self, axis: "Axis", name: str) -> None:
        """The same for an axis of inverse lengths."""
        self._write(axis, name, f"1/{self.prefixed}" if self.prefixed else "", -self.power)

    def _write(self, axis: "Axis", name: str, unit: str, power: int) -> None:
        if unit:
            name = f"{name} ({unit})"
        elif power:
            name = f"{name} / $10^{{{power}}}$"
        axis.set_label_text(name)
        axis.set_major_formatter(_formatter(power, logarithmic=axis.get_scale() == "log"))


def _formatter(power: int, logarithmic: bool) -> Any:
    from matplotlib.ticker import Formatter, LogFormatterSciNotation

    class Plain(Formatter):
        """Numbers in units of 10^power with as many digits as tell the ticks apart, and no common offset."""

        def __call__(self, value: float, position: int | None = None) -> str:
            return self.fix_minus(f"{value * 10.0**-power:.6g}")

        def format_ticks(self, values: list[float]) -> list[str]:
            steps = np.diff(np.sort(np.asarray(values, dtype=float))) * 10.0**-power
            if not steps.size or not steps.min() > 0.0:
                return [self(value) for value in values]
            step = float(steps.min())
            decimals = max(0, int(np.ceil(-np.log10(step) - 1e-6)))
            # 2.5 needs a digit more than 2
            if abs(round(step * 10.0**decimals) - step * 10.0**decimals) > 0.01:
                decimals += 1
            return [self.fix_minus(f"{value * 10.0**-power:.{decimals}f}") for value in values]

    class Logarithmic(LogFormatterSciNotation):
        def __call__(self, value: float, position: int | None = None) -> str:
            return super().__call__(value * 10.0**-power, position)

    return Logarithmic() if logarithmic else Plain()


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
    weight = -np.diff(curve.survival, append=0.0)[shown]
    seen = values[shown]
    if not seen.size or not weight.sum() > 0.0:
        return Heights(0.0, float(seen.max(initial=1.0)), False)
    order = np.argsort(seen)
    sums = np.cumsum(weight[order]) / weight.sum()
    low, high = (
        float(seen[order][np.searchsorted(sums, share)]) for share in (_SHARE, 1.0 - _SHARE)
    )
    top = float(seen.max())
    if high > _DECADES * low:
        return Heights(low / 10.0, high * 10.0, True)
    at_end = int(np.argmax(seen)) in (0, seen.size - 1)
    return Heights(0.0, 1.5 * high if top > _SPIKE * high and at_end else 1.05 * top, False)


def spans_decades(curve: ThresholdCurve) -> bool:
    """Whether half of the thresholds lie in the first thousandth of what is shown."""
    median, last = (float(curve.x[curve.survival > part].max(initial=0.0)) for part in (0.5, 1e-3))
    return 0.0 < median * _DECADES < last

"""Readable axes: names with units and SI prefixes, colours and marks that colour-blind readers distinguish, legends
beside the data."""

import textwrap
from typing import Any

import numpy as np
import numpy.typing as npt

from toolkit.scene.scale import PREFIXED, PREFIXES, SHARED, Scale

# colours by Okabe and Ito, which colour-blind readers distinguish
OKABE_ITO = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000"]
INK = {"master": OKABE_ITO[0], "eq": OKABE_ITO[1], "thresholds": OKABE_ITO[2]}
# dashes keep coinciding curves visible, marks curves of one colour apart
DASHES: list[Any] = ["-", (0, (6, 3)), (0, (1.5, 2)), (0, (6, 2, 1, 2)), (0, (10, 4))]
MARKERS = ["o", "s", "^", "D", "v", "P", "X", "*", "<", ">", "p", "h"]
OWN_UNITS = {"length": "units of length", "time": "units of time"}  # of a scene without SI units
_MOST_DECADES = 5.0  # of a logarithmic axis whose ticks are plain numbers, not powers of ten
_SHORT = (1e-3, 1e5)  # from where to where ticks are short without a power of ten
_LEAST_TICK = 0.0999  # power of ten on a logarithmic axis in the unit of its upper end
_ROW = 15.0  # height of a row of a legend in points
_HANDLE = 9  # width of a line's sample in a legend, in letters


def style_of(number: int) -> dict[str, Any]:
    """Colour, dashes and mark of the curve of this number; no two of the first 84 are alike."""
    return {
        "color": OKABE_ITO[number % len(OKABE_ITO)],
        "ls": DASHES[number % len(DASHES)],
        "marker": MARKERS[number % len(MARKERS)],
    }


def some_of(size: int, most: int) -> npt.NDArray[np.intp]:
    """Indices of at most so many of `size` points, evenly."""
    return np.unique(np.linspace(0, size - 1, most).round().astype(np.intp))


def force_name(scale: Scale, of: str = "F") -> tuple[str, str]:
    """Name and unit of an axis of forces: of a force on the area, a stress, or a force over N_c<k>, a length."""
    named = {"N": f"force ${of}$", "Pa": f"shear stress ${of}/A$"}
    if scale.force_unit in named:
        return named[scale.force_unit], scale.force_unit
    return rf"force ${of}/(N_c\langle k\rangle)$", scale.length_unit


def name_over_load(axes: Any, scale: Scale) -> None:
    """Opposite to an axis of forces that of F over the load, where that is known."""
    if (load := scale.load) is not None:
        over = axes.secondary_yaxis("right", functions=(lambda f: f / load, lambda mu: mu * load))
        low, high = axes.get_ylim()
        power = _plain_power(max(abs(low), abs(high)) / load)
        over.set_ylabel(r"$\mu = F$/load" + f" ($10^{{{power}}}$)" * bool(power))
        _without_offset(over.yaxis, power)


def spring_name(unit: str) -> tuple[str, str]:
    """Name and unit of an axis of critical springs in this unit."""
    if unit == SHARED:
        return r"critical spring $K^*/(N_c\langle k\rangle)$", ""
    return ("critical spring $K^*$" if unit == "N/m" else "critical spring per area $K^*/A$"), unit


def name_axis(axis: Any, name: str, unit: str, beside: Any = None) -> None:
    """Label an axis, once it has its data and limits, with name and unit, which takes the SI prefix that makes ticks
    short, such as µm, mN or kN/m; after a name that ends its line the unit has the next one. One in 1/m takes that of
    the axis of lengths `beside`, so that 1/nm stands beside nm."""
    low, high = axis.get_view_interval()
    gap = "" if name.endswith("\n") else " "
    inverse = unit == "1/m"
    if not (unit in PREFIXED or inverse):
        said, power = OWN_UNITS.get(unit, unit), 0
        log = axis.get_scale() == "log"
        if not log or high < 10.0**_MOST_DECADES * low:  # else ticks are powers of ten anyway
            power = _plain_power(max(abs(low), abs(high)))
            (_set_ticks if log else _without_offset)(axis, power)
        if power:
            said = f"$10^{{{power}}}$ {said}".replace(" 1/", "/").strip()
        axis.set_label_text(f"{name}{gap}({said})".removesuffix(f"{gap}()"))
        return
    power = _power(low, high, axis.get_scale() == "log", inverse, unit == "s")
    if inverse and beside is not None:
        first, last = beside.get_view_interval()
        power = -_power(first, last, beside.get_scale() == "log", False, False)
    prefixed = f"1/{PREFIXES[-power]}m" if inverse else f"{PREFIXES[power]}{unit}"
    axis.set_label_text(f"{name}{gap}({prefixed})")
    _set_ticks(axis, power)


def _plain_power(size: float) -> int:
    """The power of ten to take out of ticks as large as that: 0 where they are short without."""
    if not 0.0 < size < np.inf or _SHORT[0] <= size < _SHORT[1]:
        return 0
    return int(np.floor(np.log10(size) + 1e-9))


def _without_offset(axis: Any, power: int) -> None:
    """Ticks in multiples of 10^power, which the label has, with all their digits: matplotlib's own common factor and
    offset would stand above the axes, in the legend."""
    if power:
        _set_ticks(axis, power)
    elif hasattr(axis.get_major_formatter(), "set_useOffset"):
        axis.get_major_formatter().set_useOffset(False)


def _power(low: float, high: float, log: bool, inverse: bool, seconds: bool) -> int:
    """The power of ten of the prefix for an axis with these ends: of the upper end of a logarithmic one, if no tick is
    below 0.1 then, else of its middle, or the next, so that no tick is 10000; where that spans so many decades that
    ticks are powers of ten, of the upper end, without a large prefix."""
    wide = log and high / low > 10.0**_MOST_DECADES
    size = np.sqrt(low * high) if log and not wide else max(abs(low), abs(high))
    size = min(size, 1.0) if wide else size
    if not (np.isfinite(size) and size > 0.0):
        return 0
    power = int(3 * np.floor((np.log10(size) + 1e-9) / 3))
    upper = int(3 * np.floor((np.log10(high) + 1e-9) / 3)) if high > 0.0 else power
    if log and not wide and 10.0 ** np.ceil(np.log10(low) - 1e-9) >= _LEAST_TICK * 10.0**upper:
        power = upper
    power += 3 * (not wide and high >= 10.0 ** (power + 4))
    least, most = (-9, 15) if inverse else (-15, 0 if seconds else 12)  # 1/Gm to 1/fm
    return int(np.clip(power, least, most))


def _set_ticks(axis: Any, power: int) -> None:
    """Ticks of data in a unit, as numbers in its multiple of 10^power."""
    from matplotlib.ticker import FuncFormatter, LogFormatter, LogFormatterMathtext

    low, high = axis.get_view_interval()

    def plain(value: float) -> str:
        return f"{value / 10.0**power:.10g}".replace("-", "−")

    class Prefixed(LogFormatter):
        """Labels those ticks that a logarithmic axis labels anyway."""

        def __call__(self, x: float, pos: int | None = None) -> str:
            return plain(x) if super().__call__(x, pos) else ""

    class Powers(LogFormatterMathtext):
        """Powers of ten in the multiple of the unit."""

        def __call__(self, x: float, pos: int | None = None) -> str:
            return super().__call__(x / 10.0**power, pos)

    if axis.get_scale() == "log" and high / low > 10.0**_MOST_DECADES:
        axis.set_major_formatter(Powers())
    elif axis.get_scale() == "log":
        axis.set_major_formatter(Prefixed())
        # of an axis with one power of ten, whose label alone would tell no scale, multiples are labelled, too
        powers = np.floor(np.log10(high)) - np.ceil(np.log10(low)) + 1
        axis.set_minor_formatter(Prefixed(minor_thresholds=(0.8 if powers > 1 else 2.0, 0.4)))
    else:
        axis.set_major_formatter(FuncFormatter(lambda value, _: plain(value)))


def in_lines(title: str, letters: int = 110) -> str:
    """A title in lines of so many letters. (matplotlib's own `wrap` takes any $ of a title for a formula.)"""
    return "\n".join(textwrap.wrap(title, letters, break_on_hyphens=False))


def legend_above(axes: Any, title: str = "", letters: int = 90) -> None:
    """A legend between the axes and their title, where it covers no data; above the axes fit so many letters."""
    handles, labels = axes.get_legend_handles_labels()
    longest = max(map(len, labels), default=1) + _HANDLE
    columns = int(np.clip(letters // longest, 1, max(len(labels), 1)))
    rows = -(-len(labels) // columns)
    if title:
        axes.set_title(in_lines(title, letters), pad=6.0 + _ROW * rows, parse_math=False)
    if handles:
        place: dict[str, Any] = {"loc": "lower left", "bbox_to_anchor": (0.0, 1.0)}
        axes.legend(
            handles,
            labels,
            ncols=columns,
            frameon=False,
            fontsize="small",
            borderaxespad=0,
            **place,
        )

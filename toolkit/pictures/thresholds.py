"""Pictures of a law of thresholds: P_c, its survival and its hazard; and of islands, whose barriers they come from."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from origins.domains.domain_samples import DomainSamples
from origins.samples.from_samples import Sampled
from origins.thresholds.law import Thresholds
from toolkit.pictures.axes import INK, heights, name_lengths, plain, some_of, spans_decades
from toolkit.results.records import ThresholdCurve

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_STEPS, _ISLANDS = 2000, 20_000  # as many as a picture can show
_STYLE: dict[str, Any] = {"color": INK["thresholds"], "lw": 1.2}


def plot_density(axes: "Axes", curve: ThresholdCurve) -> "Axes":
    """P_c(x), with exact single values as lines as high as their weight."""
    finite = np.isfinite(curve.density)
    smooth = curve.density[finite].any()
    if smooth:
        _upright(axes, curve, curve.density)
        x, density = curve.x[finite], curve.density[finite]
        axes.fill_between(x, density, color=INK["thresholds"], alpha=0.25, lw=0)
        axes.plot(x, density, **_STYLE)
    _label(axes, curve, "thresholds", "threshold $x$", "$P_c(x)$")
    if curve.atoms.size:
        # a weight is no density: beside one it has an axis of its own
        own = axes.twinx() if smooth else axes
        own.vlines(curve.atoms, 0.0, curve.atom_weights, color=INK["thresholds"], lw=2)
        own.set(ylabel="weight at one value", ylim=(0.0, 1.05 * float(curve.atom_weights.max())))
    return axes


def plot_survival(axes: "Axes", curve: ThresholdCurve) -> "Axes":
    """S(x), the probability that a threshold exceeds x."""
    axes.plot(curve.x, curve.survival, **_STYLE)
    axes.set(ylabel="$S(x)$", ylim=(0, 1.05))
    _label(axes, curve, "survival", "threshold $x$")
    return axes


def plot_samples(axes: "Axes", thresholds: Thresholds) -> "Axes":
    """Over S(x) the share of samples above x, as steps; nothing for a law that is not from samples."""
    if isinstance(thresholds, Sampled):
        x, above = thresholds.samples, 1.0 - np.cumsum(thresholds.shares)
        some = some_of(x.size, _STEPS)
        label = f"{thresholds.n_samples} samples"
        axes.step(x[some], above[some], where="post", color="0.25", lw=0.6, label=label)
        axes.legend()
    return axes


def plot_hazard(axes: "Axes", curve: ThresholdCurve) -> "Axes":
    """P_c(x)/S(x), the rate of breaking per length at stretch x, up to where one contact in a thousand holds."""
    shown = (curve.survival > 1e-3) & np.isfinite(curve.density)
    hazard = np.where(shown, curve.density / np.maximum(curve.survival, 1e-3), np.nan)
    if shown.any():
        _upright(axes, curve, hazard)
    axes.plot(curve.x[shown], hazard[shown], **_STYLE)
    _label(axes, curve, "hazard", "stretch $x$", "$P_c(x)/S(x)$")
    return axes


def _upright(axes: "Axes", curve: ThresholdCurve, values: Any) -> None:
    """The limits of y."""
    found = heights(curve, values)
    axes.set(yscale="log" if found.logarithmic else "linear", ylim=(found.bottom, found.top))


def _label(
    axes: "Axes", curve: ThresholdCurve, title: str, name: str, inverse: str | None = None
) -> None:
    """Title, the axis of x, a little beyond all but a thousandth of the thresholds, from 0 unless they all lie far from
    it; and, where it is one of inverse lengths, that of y."""
    first = float(curve.x[curve.survival < 1.0 - 1e-3].min())
    last = float(curve.x[curve.survival > 1e-3].max(initial=first))
    # one exact value has no width of its own
    margin = 0.15 * (last - first) if last - first > 1e-9 * last else 0.5 * last
    first = first - margin if first > 0.5 * last else 0.0
    axes.set_title(title)
    if spans_decades(curve):
        first = float(curve.x[curve.x > 0.0].min())
        axes.set_xscale("log")
    axes.set_xlim(first, last + margin)
    name_lengths(axes.xaxis, name, curve.in_metres)
    if inverse is not None:
        axes.set_ylabel(f"{inverse} (1/m)" if curve.in_metres else inverse)


def save_thresholds_picture(
    curve: ThresholdCurve, thresholds: Thresholds, title: str, path: Path
) -> None:
    """P_c, survival, that of the samples if there are any over it, and hazard side by side as a PNG."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11.5, 3.6), layout="constrained")
    axes = figure.subplots(1, 3)
    plot_density(axes[0], curve)
    plot_samples(plot_survival(axes[1], curve), thresholds)
    plot_hazard(axes[2], curve)
    figure.suptitle(plain(title))
    figure.savefig(path, dpi=150, format="png")


def save_barriers(domains: DomainSamples, path: Path) -> None:
    """Barrier of each island that was drawn, against its angle in degrees, as a PNG; larger islands darker."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7, 4), layout="constrained")
    axes, some = figure.subplots(), slice(_ISLANDS)
    place = np.degrees(domains.angles[some]), domains.barriers[some]
    shown = axes.scatter(*place, c=domains.n_atoms[some], cmap="viridis_r", s=3.0, lw=0.0)
    figure.colorbar(shown, label="atoms")
    axes.set(xlabel="angle (degrees)", ylabel=r"barrier $\epsilon_a$ (energy)", ylim=(0.0, None))
    figure.savefig(path, dpi=150, format="png")

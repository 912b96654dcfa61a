"""Pictures of a law of thresholds: P_c, its survival and its hazard; and of islands, whose barriers they come from."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from origins.domains.domain_samples import DomainSamples
from origins.samples.from_samples import Sampled
from origins.thresholds.law import Thresholds
from toolkit.pictures.axes import INK, Array, highest, name_lengths, plain, some_of
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
        axes.fill_between(
            curve.x[finite], curve.density[finite], alpha=0.25, lw=0, color=INK["thresholds"]
        )
        _draw(axes, curve, np.where(finite, curve.density, np.nan), "$P_c(x)$")
    _label(axes, curve, "thresholds", "threshold $x$")
    if curve.atoms.size:
        # a weight is no density: beside one it has an axis of its own
        own = axes.twinx() if smooth else axes
        own.vlines(curve.atoms, 0.0, curve.atom_weights, color=INK["thresholds"], lw=2)
        own.set(ylabel="weight at one value", ylim=(0.0, 1.05 * float(curve.atom_weights.max())))
    return axes


def plot_samples(axes: "Axes", thresholds: Thresholds) -> "Axes":
    """Over S(x) the share of samples above x, as steps; nothing for a law that is not from samples."""
    if isinstance(thresholds, Sampled):
        some = some_of(thresholds.samples.size, _STEPS)
        above = 1.0 - np.cumsum(thresholds.shares)[some]
        label = f"{thresholds.n_samples} samples"
        axes.step(thresholds.samples[some], above, where="post", color="0.25", lw=0.6, label=label)
        axes.legend()
    return axes


def _draw(axes: "Axes", curve: ThresholdCurve, values: Array, name: str) -> None:
    """A quantity per length, within limits that show it."""
    axes.plot(curve.x, values, **_STYLE)
    axes.set(
        ylabel=f"{name} (1/m)" if curve.in_metres else name, ylim=(0.0, highest(curve, values))
    )


def _label(axes: "Axes", curve: ThresholdCurve, title: str, name: str) -> None:
    """Title, and the axis of x: a little beyond all but a thousandth of the thresholds, from 0 unless they all lie far
    from it."""
    first = float(curve.x[curve.survival < 1.0 - 1e-3].min())
    last = float(curve.x[curve.survival > 1e-3].max(initial=first))
    # one exact value has no width of its own
    margin = 0.15 * (last - first) if last - first > 1e-9 * last else 0.5 * last
    axes.set(title=title, xlim=(first - margin if first > 0.5 * last else 0.0, last + margin))
    name_lengths(axes.xaxis, name, curve.in_metres)


def save_thresholds_picture(
    thresholds: Thresholds, curve: ThresholdCurve, title: str, path: Path
) -> None:
    """P_c, survival S, with that of the samples if there are any over it, and hazard P_c/S, the rate of breaking per
    length up to where one contact in a thousand holds, side by side as a PNG."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11.5, 3.6), layout="constrained")
    density, survival, hazard = figure.subplots(1, 3)
    plot_density(density, curve)
    survival.plot(curve.x, curve.survival, **_STYLE)
    survival.set(ylabel="$S(x)$", ylim=(0, 1.05))
    _label(plot_samples(survival, thresholds), curve, "survival", "threshold $x$")
    shown = (curve.survival > 1e-3) & np.isfinite(curve.density)
    values = np.where(shown, curve.density / np.maximum(curve.survival, 1e-3), np.nan)
    _draw(hazard, curve, values, "$P_c(x)/S(x)$")
    _label(hazard, curve, "hazard", "stretch $x$")
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

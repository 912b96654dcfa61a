"""Pictures of a law of thresholds and of the islands whose barriers it comes from."""

from pathlib import Path
from typing import Any

import numpy as np

from origins.domains.rotated import DomainSamples
from origins.samples.from_samples import Sampled
from origins.thresholds.law import Array, Thresholds
from toolkit.pictures.axes import INK, legend_above, name_axis, some_of
from toolkit.results.records import ThresholdCurve

_SPIKE = 10.0  # a density is cut off at this multiple of its largest value for 95 % of the contacts
_STEPS, _ISLANDS = 2000, 20_000  # most points that a picture shows
_OF_SAMPLES = "0.25"
# fewest samples that have a histogram; fewest and most of its bars
_FEWEST_BARRED, _BARS = 5, (3, 200)
_STYLE: dict[str, Any] = {"color": INK["thresholds"], "lw": 1.2}


def highest(curve: ThresholdCurve, values: Array) -> float:
    """Upper limit of an axis that shows `values` over curve.x, however narrow their peaks; a spike at an end of
    the law, where a density diverges, is cut off above the largest value for 95 % of the contacts."""
    shown = np.isfinite(values) & (values > 0.0)
    weight, seen = -np.diff(curve.survival, append=0.0)[shown], values[shown]
    if not weight.sum() > 0.0:
        return float(seen.max(initial=1.0))
    order, top = np.argsort(seen), float(seen.max())
    high = seen[order][np.searchsorted(weight[order].cumsum(), 0.95 * weight.sum())]
    at_end = int(np.argmax(seen)) in (0, seen.size - 1)
    return float(1.5 * high) if top > _SPIKE * high and at_end else 1.05 * top


def plot_density(axes: Any, curve: ThresholdCurve) -> Any:
    """P_c(x), with exact single values as lines as high as their weight."""
    _label(axes, curve, "thresholds", "threshold $x_s$")
    finite = np.isfinite(curve.density)
    smooth = curve.density[finite].any()
    if smooth:
        filled = {"alpha": 0.25, "lw": 0, "color": INK["thresholds"]}
        axes.fill_between(curve.x[finite], curve.density[finite], **filled)
        _draw(axes, curve, np.where(finite, curve.density, np.nan), "$P_c(x_s)$")
    if curve.atoms.size:
        # a weight is not a density: next to one it has its own axis
        own = axes.twinx() if smooth else axes
        own.vlines(curve.atoms, 0.0, curve.atom_weights, color=INK["thresholds"], lw=2)
        top = 1.0 if smooth else float(curve.atom_weights.max())
        own.set(ylabel="weight at one value", ylim=(0.0, 1.05 * top))
    return axes


def plot_histogram(axes: Any, thresholds: Thresholds) -> Any:
    """Add to P_c(x) a histogram of the samples, without exact values, which are no density; nothing for a law that is
    not from samples."""
    if not isinstance(thresholds, Sampled):
        return axes
    smooth = ~np.isin(thresholds.samples, thresholds.atoms[0])
    x, fractions = thresholds.samples[smooth], thresholds.fractions[smooth]
    if x.size < _FEWEST_BARRED:
        return axes
    # bars as wide as Freedman and Diaconis ask for; the samples are sorted
    low, high = np.interp([0.25, 0.75], np.cumsum(fractions) / fractions.sum(), x)
    width = 2.0 * (high - low) / thresholds.effective_samples ** (1.0 / 3.0)
    bars = int(np.clip(np.ceil(np.ptp(x) / width), *_BARS)) if width > 0.0 else _BARS[1]
    share, edges = np.histogram(x, bars, weights=fractions)
    density = share / np.diff(edges)
    axes.stairs(
        density, edges, color=_OF_SAMPLES, lw=0.8, label=f"{thresholds.n_samples:,} samples"
    )
    axes.set_ylim(0.0, max(axes.get_ylim()[1], 1.05 * float(density.max())))
    return axes


def plot_samples(axes: Any, thresholds: Thresholds) -> Any:
    """Add to S(x) the share of samples above x, as steps; nothing for a law that is not from samples."""
    if isinstance(thresholds, Sampled):
        some = some_of(thresholds.samples.size, _STEPS)
        x = np.append(0.0, thresholds.samples[some])
        above = 1.0 - np.append(0.0, np.cumsum(thresholds.fractions)[some])
        label = f"{thresholds.n_samples:,} samples"
        axes.step(x, above, where="post", color=_OF_SAMPLES, lw=0.6, label=label)
        legend_above(axes)
    return axes


def _draw(axes: Any, curve: ThresholdCurve, values: Array, name: str) -> None:
    """A quantity per length, within limits that show it, beside an axis of lengths that is labelled."""
    axes.plot(curve.x, values, **_STYLE)
    axes.set_ylim(0.0, highest(curve, values))
    name_axis(axes.yaxis, name, "1/m" if curve.in_metres else "1/length", axes.xaxis)


def _label(axes: Any, curve: ThresholdCurve, title: str, name: str) -> None:
    """Title, and the axis of x: a little beyond all but a thousandth of the thresholds, from 0 unless they all lie far
    from it."""
    first = float(curve.x[curve.survival < 1.0 - 1e-3].min())
    last = float(curve.x[curve.survival > 1e-3].max(initial=first))
    # one exact value has no width of its own
    margin = 0.15 * (last - first) if last - first > 1e-9 * last else 0.5 * last
    axes.set_xlim(first - margin if first > 0.5 * last else 0.0, last + margin)
    legend_above(axes, title=title)
    name_axis(axes.xaxis, name, "m" if curve.in_metres else "length")


def save_thresholds_picture(law: Thresholds, curve: ThresholdCurve, title: str, path: Path) -> None:
    """P_c and survival S, with those of the samples if there are any over them, and hazard P_c/S, the rate of breaking
    per length up to where one contact in a thousand holds, side by side, in the format of the path's suffix."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11.5, 3.6), layout="constrained")
    density, survival, hazard = figure.subplots(1, 3)
    plot_histogram(plot_density(density, curve), law)
    legend_above(density, title="thresholds")
    survival.plot(curve.x, curve.survival, **_STYLE)
    survival.set(ylabel="survival $S(x_s)$", ylim=(0, 1.05))
    _label(plot_samples(survival, law), curve, "survival", "threshold $x_s$")
    shown = (curve.survival > 1e-3) & np.isfinite(curve.density)
    values = np.where(shown, curve.density / np.maximum(curve.survival, 1e-3), np.nan)
    _label(hazard, curve, "hazard", "stretch $x$")
    _draw(hazard, curve, values, "$P_c(x)/S(x)$")
    figure.suptitle(title, parse_math=False)
    figure.savefig(path, dpi=150, format=path.suffix[1:])


def save_barriers(domains: DomainSamples, path: Path) -> None:
    """Barrier of each island that was drawn, against its angle in degrees; of several sizes larger ones darker. The
    format is that of the path's suffix."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7, 4), layout="constrained")
    axes, some = figure.subplots(), slice(_ISLANDS)
    place = np.degrees(domains.angles[some]), domains.barriers[some]
    atoms = domains.n_atoms[some]
    if np.ptp(atoms):
        shown = axes.scatter(*place, c=atoms, cmap="viridis_r", s=3.0, lw=0.0)
        figure.colorbar(shown, label="atoms")
    else:  # a scale of one size would say nothing
        axes.scatter(*place, color=INK["thresholds"], s=3.0, lw=0.0)
        axes.set_title(f"{atoms[0]:,} atoms")
    axes.set(xlabel="angle (degrees)", ylabel=r"barrier $\epsilon_a$ (energy)", ylim=(0.0, None))
    figure.savefig(path, dpi=150, format=path.suffix[1:])

"""Remarks on thresholds from samples, and on those of islands, which are samples of their angles."""

import numpy as np

from origins.domains.islands import Layers
from origins.samples.from_samples import Sampled, sampled_parts
from origins.thresholds.law import Thresholds

# of a sampling error: what smoothing adds to F_k below it is no news
NO_NEWS = 0.1


def of_islands(law: Thresholds, machine: bool = False) -> list[str]:
    """Notes on thresholds from islands: layers of their atoms; K* is infinite, with the slips of some springs but
    beside a `machine` of its own, or depends on smoothing."""
    if law.domains is None:
        return []
    layered = [_of_layers(island) for island in law.domains.layers if island.layers > 1]
    return layered + _of_angles(law, machine)


def _of_layers(island: Layers) -> str:
    """What is said of an island of several layers, whose atoms all meet the substrate alike, and what is asked where
    one of them may be the substrate itself."""
    what = f"the island is {island.atoms:,} atoms, {island.formula}, in {island.layers} layers"
    if len(island.apart) > 1:
        return (
            f"{what}, {' below '.join(island.apart)}: is the substrate among them? Each of these atoms is taken as one "
            "of the island: leave those of the substrate out of the file, as the table substrate states it"
        )
    return (
        f"{what}, and all of them meet the substrate alike, whatever their z: leave those that do not touch it out of "
        "the file"
    )


def _of_angles(law: Thresholds, machine: bool) -> list[str]:
    """Notes on the angles of islands, and on K* of the P_c that they have."""
    angles = law.domains.angles
    if angles.max() > 1.0 and (angles == angles.round()).all():
        return ["angles are in radians, and all of them are whole numbers: are degrees meant?"]
    if law.atoms[0].size:
        return []
    if of_smoothing(law):
        if few := of_listed_angles(law):
            return few
        return [
            "P_c of islands at all angles peaks where a barrier stands still in the angle, and samples smooth "
            "that away: K* hangs on the smoothing, and is no number of the islands"
        ]
    with np.errstate(divide="ignore"):
        peaks = law.breakpoints[np.isinf(law.pdf(law.breakpoints))]
    if not peaks.size:
        return []
    why = "K* is infinite: P_c peaks as an inverse square root where a barrier stands still in the angle"
    if machine:
        return [why]
    drops = []
    for spring in (1.0, 10.0, 100.0):
        slip = longest_slip(law, peaks, spring) / law.mean()
        at = f"a slip of {slip:.2g} <x_s> at K = {spring:g} N<k>"
        drops.append(f"{spring * slip:.2g} <x_s> in {at}")
    return [
        f"{why}; as relaxed contacts break for the first time, F/(N<k>) drops at most by about {', '.join(drops)}"
    ]


def of_smoothing(law: Thresholds) -> bool:
    """Whether K* of these islands is no number of theirs, but one of how samples of their thresholds are smoothed."""
    return law.domains is not None and isinstance(law, Sampled) and not law.atoms[0].size


def of_listed_angles(law: Thresholds) -> list[str]:
    """A note on islands at few listed angles, taken in turn, whose barriers are told by a smooth law; else none."""
    if law.domains is None or not isinstance(law, Sampled) or law.atoms[0].size:
        return []
    many = np.unique(law.domains.angles).size
    if many >= law.domains.angles.size / 2:
        return []
    return [
        f"P_c is a smooth law with narrow peaks at the barriers of {many} listed angles: F_k is that of the exact "
        "values, whose K* is infinite; this one's hangs on the smoothing, and takes minutes: leave angles out, or list "
        "8 at most, which are taken as exact"
    ]


def longest_slip(law: Thresholds, peaks: np.ndarray, spring: float) -> float:
    """The longest slip (a length) of relaxed contacts under a spring of K/(N<k>), at T = 0.

    F(X) = X - int_0^X x P_c dx until contacts break for the second time; a slip leads from where F + K X stops
    rising to where it is as high again.
    """
    lower, upper = law.support()
    away = np.geomspace(1e-14, 1.0, 6000)  # of a peak's place
    x = np.concatenate([peaks, *(peak * (1.0 + s * away) for peak in peaks for s in (-1, 1))])
    x = np.unique(np.append(x[(x > lower) & (x < 2.0 * upper)], [lower, upper]))
    below, above = law.cdf(x), law.sf(x)
    fraction = np.where(below[1:] < 0.5, np.diff(below), -np.diff(above))
    rise = np.diff(x) * (1.0 + spring) - 0.5 * (x[1:] + x[:-1]) * fraction
    height = np.concatenate([[0.0], np.cumsum(rise)])
    top = np.maximum.accumulate(height)
    last = np.maximum.accumulate(np.where(height >= top, np.arange(x.size), 0))
    return float((x - x[last]).max())


def of_samples(law: Thresholds) -> list[str]:
    """A note for each law of few samples, or further from its samples than these can be from their own law."""
    notes = []
    for part in sampled_parts(law):
        if part.effective_samples < 29.5 or part.cdf_misfit > part.cdf_error:
            note = f"few thresholds, or structure that their smooth law misses: {part.n_samples} samples, worth "
            note += f"{part.effective_samples:.3g}; its cdf lies {part.cdf_misfit:.2g} from theirs, sampling allows "
            more = "take more samples, or give peaks apart, in a mixture"
            if law.domains is not None:  # the program draws them
                more = "raise samples of the thresholds' table, or trust no detail of P_c"
            note += f"{part.cdf_error:.2g}; {more}"
            notes.append(note)
        notes += _of_smoothed_force(part)
    return notes


def _of_smoothed_force(part: Sampled) -> list[str]:
    """A note where F_k = <x²>/2<x> of the smooth law is not that of its samples, by more than NO_NEWS of the standard
    error of the latter, that of <x² - 2 F_k x>/2<x>; else none. Smoothing keeps <x> alone."""
    x, weights = part.samples, part.fractions
    mean = float(weights @ x)
    kinetic = float(weights @ x**2) / (2.0 * mean)
    each = (x**2 - 2.0 * kinetic * x) / (2.0 * mean)
    error = float(np.sqrt(weights @ each**2 / part.effective_samples))
    off = part.moment(2) / (2.0 * mean) - kinetic
    if abs(off) <= NO_NEWS * error:
        return []
    side = "above" if off > 0.0 else "below"
    return [
        f"F_k of the smooth law is {abs(off) / kinetic:.2%} {side} <x²>/(2<x>) of the {part.n_samples:,} samples "
        f"themselves, whose standard error is {error / kinetic:.2%}: smoothing keeps <x> alone"
    ]

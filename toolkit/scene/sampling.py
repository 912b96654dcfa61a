"""Sampling errors of what a comparison and a table state, for thresholds that come from samples."""

import numpy as np

from origins import Contacts, bootstrap
from origins.samples.bootstrap import sampled_parts
from origins.samples.repeats import OFTEN
from origins.thresholds.continuous_mixture import ContinuousMixture
from origins.thresholds.law import Array, Thresholds

FEW = 30  # samples, in effect
RESAMPLES = 20  # an error known to a sixth of itself
_TOLERANCE = 1e-4  # far below any sampling error
NAMES = (
    *("mean", "standard_deviation", "second_moment", "third_moment"),
    *("one_in_a_hundred_below", "median", "one_in_a_hundred_above"),
    *("kinetic_force", "critical_spring", "static_to_kinetic", "decoherence_length"),
)


def sampling_errors(contacts: Contacts) -> dict[str, float]:
    """One standard error of each of NAMES, bias of the smoothing included; lengths in the unit of the thresholds.

    inf for K* and F_s/F_k where all resampled laws have the least value there is, 0 and 1: then no error can be read
    off (see unseen). Empty where the thresholds do not come from samples.
    """
    if not sampled_parts(contacts.thresholds) or isinstance(contacts.thresholds, ContinuousMixture):
        return {}

    def statistic(law: Thresholds) -> Array:
        import master

        found = master.propensity(Contacts(law, start=contacts.start), tolerance=_TOLERANCE)
        numbers = [law.mean(), law.std(), law.moment(2), law.moment(3)]
        numbers += [float(law.ppf(0.01)), float(law.ppf(0.5)), float(law.isf(0.01))]
        # K* and X* may be infinite: their inverses are not
        numbers += [law.moment(2) / (2.0 * law.mean()), 1.0 / (1.0 + found.critical_spring)]
        return np.array([*numbers, found.static_to_kinetic, 1.0 / found.decoherence_length])

    spread = bootstrap(contacts.thresholds, statistic, resamples=RESAMPLES)
    errors = {}
    for name, value, error in zip(NAMES, spread.value, np.array(spread.error), strict=True):
        if name in ("critical_spring", "decoherence_length") and error > 0.0:
            error = error / value**2 if value > 0.0 else np.inf
        if name in ("critical_spring", "static_to_kinetic") and value == 1.0 and error == 0.0:
            error = np.inf
        errors[name] = float(error)
    return errors


def unseen(errors: dict[str, float], critical_spring: float) -> list[str]:
    """A note where no resampled law shows an instability, so that the error of K* = 0 is not known; else nothing."""
    if critical_spring > 0.0 or np.isfinite(errors.get("critical_spring", 0.0)):
        return []
    chance = 1.0 - 0.05 ** (1.0 / RESAMPLES)
    return [
        f"K* = 0 in all {RESAMPLES} resampled laws too: other samples would give K* > 0 in less than {chance:.0%} of "
        "cases (95% confidence), and how large it would be is not known"
    ]


def numerical_only(law: Thresholds) -> list[str]:
    """A note that errors of a run know nothing of the sampling, where there is any."""
    told = (
        "errors are numerical only, not those of the samples: what others would give is not in them; `mesofriction "
        "thresholds`, `mesofriction compare` and origins.bootstrap tell sampling errors"
    )
    return [told] if sampled_parts(law) else []


def misfit(law: Thresholds) -> list[str]:
    """A note for each law of few samples, or that lies further from its samples than these can be from their own law,
    and one where sampling errors are missing; else nothing."""
    notes = []
    for part in sampled_parts(law):
        few, misses = round(part.effective_samples) < FEW, part.cdf_misfit > part.cdf_error
        alike = part.effective_samples > 0.99 * part.n_samples
        count = "" if alike else f", which their weights make {part.effective_samples:.2g}"
        told = f"few thresholds, {part.n_samples} samples{count}: " if few else ""
        told += f"the smooth law's cdf lies {part.cdf_misfit:.2g} from that of the samples, sampling allows "
        told += f"{min(part.cdf_error, 1.0):.2g}{'; take more samples' if few else ''}"
        if misses:
            told += "; they are rounded coarsely, or hold structure that it misses; give that apart, in a mixture"
        if alike and part.smooth_part is not None and part.samples.size < part.n_samples:
            told += f"; values that repeat are exact from {OFTEN} times on; those you know to be exact are `identical`"
        notes += [told] if few or misses else []
    if sampled_parts(law) and isinstance(law, ContinuousMixture):
        missing = "the laws of this continuous mixture may all be of the same samples"
        notes.append(f"sampling errors are missing: {missing}")
    return notes

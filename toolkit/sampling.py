"""Sampling errors of what a comparison and a table state, for thresholds that come from samples."""

import numpy as np

from origins import Contacts, bootstrap
from origins.samples import Sampled
from origins.thresholds import Array, Thresholds

RESAMPLES = 20  # an error known to a sixth of itself
_TOLERANCE = 1e-4  # far below any sampling error
NAMES = (
    "mean",
    "standard_deviation",
    "second_moment",
    "third_moment",
    "one_in_a_hundred_below",
    "median",
    "one_in_a_hundred_above",
    "kinetic_force",
    "critical_spring",
    "static_to_kinetic",
    "decoherence_length",
)


def sampling_errors(contacts: Contacts) -> dict[str, float]:
    """One standard error of each of NAMES, bias of the smoothing included; lengths in the unit of the thresholds.

    Empty where the thresholds do not come from samples.
    """
    if not isinstance(contacts.thresholds, Sampled):
        return {}
    start = contacts.start

    def statistic(law: Thresholds) -> Array:
        import master

        resampled = Contacts(law, start=start)
        found = master.propensity(resampled, tolerance=_TOLERANCE)
        moments = [law.mean(), law.std(), law.moment(2), law.moment(3)]
        quantiles = [float(law.ppf(0.01)), float(law.ppf(0.5)), float(law.isf(0.01))]
        # X* may be infinite: its inverse is not
        derived = [found.critical_spring, found.static_to_kinetic, 1.0 / found.decoherence_length]
        return np.array([*moments, *quantiles, law.moment(2) / (2.0 * law.mean()), *derived])

    spread = bootstrap(contacts.thresholds, statistic, resamples=RESAMPLES)
    errors = np.array(spread.error)
    rate = spread.value[-1]
    errors[-1] = errors[-1] / rate**2 if rate > 0.0 else np.inf
    return dict(zip(NAMES, errors.tolist(), strict=True))


def misfit(law: Thresholds) -> list[str]:
    """A note where the smooth law lies further from its samples than these can be from their own; else nothing."""
    if not isinstance(law, Sampled) or law.cdf_misfit <= law.cdf_error:
        return []
    off, allowed = f"{law.cdf_misfit:.2g}", f"{law.cdf_error:.2g}"
    return [
        f"the smooth law's cdf lies {off} from that of the samples, sampling allows {allowed}: they are rounded "
        "coarsely, or hold structure that it misses; give that apart, in a mixture"
    ]

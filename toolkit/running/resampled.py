"""What other samples would have given: work on resampled laws, several at once."""

import math
import time
import warnings
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any, TypeVar

import numpy as np

from origins.contacts import Contacts
from origins.errors import refuse
from origins.laws.proportional import ProportionalGrowth
from origins.laws.temperature import TooHot
from origins.samples.from_samples import Sampled, bootstrap_law
from origins.thresholds.law import Array, Thresholds
from origins.thresholds.mixture import Mixture
from toolkit.processes.ranks import cores_of

T = TypeVar("T")

# resampled laws of what has no closed form: the relative error of its scatter is then a sixth, see `known_to`
RESAMPLES = 20
# a step of moments in the imaginary direction, by which their functions are differentiated without a difference
_STEP = 1e-30
# numbers of a law by the moments of x_s/<x_s> - 1, in units of <x_s> to the power beside them
_OF_MOMENTS: dict[str, tuple[Callable[[Any], Any], int]] = {
    "mean": (lambda m: 1.0 + m[0], 1),
    "standard_deviation": (lambda m: np.sqrt(m[1] - m[0] ** 2), 1),
    "second_moment": (lambda m: 1.0 + 2.0 * m[0] + m[1], 2),
    "third_moment": (lambda m: 1.0 + 3.0 * (m[0] + m[1]) + m[2], 3),
    "kinetic_force": (lambda m: (1.0 + 2.0 * m[0] + m[1]) / (2.0 * (1.0 + m[0])), 1),
    "linked_force": (lambda m: (1.0 + 3.0 * (m[0] + m[1]) + m[2]) / (2.0 * (1.0 + m[0]) ** 2), 1),
}


def like(contacts: Contacts, law: Thresholds) -> Contacts:
    """These contacts with a resampled law in place of their own, and all other laws as they are: in strong heat, where
    F_k is a small part of that without, other samples change it by that much less, too. Raises InputError for
    thresholds that change by a law which would be lost."""
    growth = contacts.changing
    if growth is None or contacts.ageing is not None:
        return contacts.replace(thresholds=law)
    if not isinstance(growth, ProportionalGrowth):
        hint = "has no other samples, which are those of thresholds that stay, age or grow by one factor"
        hint += "; give a law that is not from samples, or an origins.ProportionalGrowth"
        refuse("contacts.thresholds", growth, hint)
    return contacts.replace(thresholds=growth.over(law))


def of_resampled(
    law: Thresholds,
    count: int,
    work: Callable[[Thresholds], T],
    progress: Callable[[int, int], None] | None = None,
    until: float = math.inf,
) -> list[T]:
    """The results of `work` on so many laws that other samples would have given, in their order.

    Smoothing and `work` spend their time in products of matrices, which release Python's lock: one thread a core.
    `progress` is called as progress(done, count). An exception ends the work after the laws that are begun, as does the
    time `until`, in s of the monotonic clock: the results are then those of fewer laws.
    """
    found = list[T]()
    pool = ThreadPoolExecutor(min(cores_of(None), count))
    with warnings.catch_warnings():
        # what holds of the law of the samples themselves is told of these
        warnings.simplefilter("ignore", TooHot)
        try:
            for one in pool.map(lambda replica: work(bootstrap_law(law, replica)), range(count)):
                found.append(one)
                if progress is not None:
                    progress(len(found), count)
                if time.monotonic() > until:
                    break
        finally:
            pool.shutdown(wait=True, cancel_futures=True)
    return found


# Of 400 samples of a lognormal law of std 0.4 in ln x_s, whose K* is 0.031 N<k>, six sets gave 0.017 to 0.128 and
# errors of 0.016 to 0.06, two of them 2.7 and 2.9 errors too large; of a normal law of std 0.2, whose K* is 1.04, six
# sets gave 0.96 to 1.10, none off by more than 1.5 errors.
RATHER_LARGE = (
    "chance lumps among the samples make F fall more steeply, so that a K* far below N<k> is rather too large: more "
    "samples, or a smooth law fitted to them, tell it better"
)


def scatter_of(value: float, others: Sequence[float]) -> float:
    """One standard error of what other samples would have given: the scatter of resampled numbers, and what smoothing
    shifts them by; nan where one is infinite."""
    with np.errstate(invalid="ignore"):
        return float(np.hypot(np.std(others, ddof=1), np.mean(others) - value))


def known_to(count: int) -> float:
    """The relative error of a scatter of so many resampled numbers."""
    return (2.0 * (count - 1)) ** -0.5


def kinetic_name(contacts: Contacts) -> str | None:
    """The name of F_k in `error_by_moments`; None where time matters to the contacts, as no moments tell F_k then."""
    if contacts.in_time:
        return None
    return "linked_force" if contacts.stiffness == "linked" else "kinetic_force"


def has_closed_form(name: str) -> bool:
    """Whether `error_by_moments` knows this number."""
    return name in _OF_MOMENTS


def error_by_moments(law: Thresholds, name: str, value: float) -> float:
    """One standard error of a number of a law from samples that its moments tell, in closed form: by the delta method
    from the scatter of the samples themselves, and by how much smoothing shifts the law's own `value`."""
    unit, (of, power) = law.mean(), _OF_MOMENTS[name]
    moments = _moments(law, unit)
    steps = 1j * _STEP * np.eye(moments.size)
    gradient = np.array([np.imag(of(moments + step)) / _STEP for step in steps])
    error = _variance(law, unit, gradient) ** 0.5
    return float(np.hypot(error * unit**power, value - of(moments) * unit**power))


def _moments(law: Thresholds, unit: float) -> Array:
    """The first three moments of x_s/unit - 1, in samples of these themselves."""
    if isinstance(law, Sampled):
        return np.array([law.fractions @ (law.samples / unit - 1.0) ** k for k in (1, 2, 3)])
    if isinstance(law, Mixture):
        each = [_moments(part, unit) for part in law.components]
        return np.asarray(np.asarray(law.weights) @ np.array(each))
    first, second, third = (law.moment(k) / unit**k for k in (1, 2, 3))
    return np.array([first - 1.0, second - 2.0 * first + 1.0, third - 3.0 * (second - first) - 1.0])


def _variance(law: Thresholds, unit: float, gradient: Array) -> float:
    """The variance over other samples of the sum of these moments, each times its part of the gradient."""
    if isinstance(law, Sampled):
        y = law.samples / unit - 1.0
        each = gradient @ np.array([y, y**2, y**3])
        return float(law.fractions @ (each - law.fractions @ each) ** 2) / law.effective_samples
    if isinstance(law, Mixture):
        parts = zip(law.weights, law.components, strict=True)
        return sum(float(w) ** 2 * _variance(part, unit, gradient) for w, part in parts)
    return 0.0

"""F(X) of Gaussian thresholds in closed form, by which solvers are judged."""

import numpy as np
import scipy

from origins.contacts import Contacts
from origins.errors import InputError
from origins.start import GaussianStart
from origins.thresholds.gaussian import CutGaussian
from origins.thresholds.law import Array


def closed_form(contacts: Contacts, path: Array) -> tuple[Array, float]:
    """F/(N_c<k>) of Gaussian thresholds from one stretch or a Gaussian of them, and a bound on its round-off in mean
    thresholds. Raises InputError for other contacts, and where the cut of a law at 0 matters.

    With thresholds of mean m and width s, and starts of mean x_0 and width s_0, the n-th break of a contact comes at
    X_n, normal with mean n m - x_0 and variance n s^2 + s_0^2, and then the n-th threshold is released, so that
    F = x_0 + X - sum over n of E[threshold n; X_n < X].
    """
    law, start = contacts.thresholds, contacts.start
    if isinstance(law, CutGaussian) and (start.is_single or isinstance(start, GaussianStart)):
        mean, width, first = law.parent_mean, law.parent_std, start.mean()
        spread = 0.0 if start.is_single else 1.0 / (np.sqrt(2.0 * np.pi) * float(start.pdf(first)))
        narrowest = float(np.hypot(width, spread))
        largest = float(path[-1]) + abs(first) + abs(mean)
        cut = scipy.special.ndtr((np.array([first, -first]) - mean) / narrowest).sum()
        cut += (largest / abs(mean) + 1.0) * scipy.special.ndtr(-mean / width)
        # the error for a contact that the cut affects, in any generation, is at most its travel
        if mean > 0.0 and cut * largest <= 1e-16 * mean:
            force, count, z = first + path, 0, np.zeros(1)
            while z[-1] >= -10.0:
                count += 1
                scatter = np.sqrt(count * width**2 + spread**2)
                z = (path - count * mean + first) / scatter
                bell = np.exp(-0.5 * z * z) / np.sqrt(2.0 * np.pi)
                force -= mean * scipy.special.ndtr(z) - width**2 / scatter * bell
            # each term and its argument are rounded, and the latter matters more the narrower the laws are
            return force, float(2.0**-53 * (count + 4.0 + mean / narrowest) * largest / mean)
    hint = "needs F in closed form: Gaussian thresholds far from 0, from one stretch or a Gaussian"
    raise InputError(f"precision: {hint} of them")

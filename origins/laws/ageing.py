"""Ageing: the threshold of a contact that holds diffuses towards the law of old contacts (paper, Sec. V)."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from origins.errors import InputError, non_negative, one_of, refuse
from origins.thresholds.gaussian import CutGaussian
from origins.thresholds.law import Array, Thresholds
from origins.thresholds.scipy_laws import as_thresholds


class Ageing:
    """Fresh thresholds P_ci diffuse towards P_cf ~ exp(-Ũ): ∂P/∂t = D ∂_x (Ũ' + ∂_x) P (paper, Eq. B).

    Parameters
    ----------
    final : Thresholds or frozen scipy.stats distribution on x >= 0
        P_cf, of contacts that have held for a long time. P_ci are the thresholds of origins.Contacts.
    rate : float
        D, a length squared per time. 0: nothing ages.
    closure : "exact" or "paper"
        "exact": the threshold of each contact diffuses independently, and the contact breaks where |x| meets it.
        "paper": one P_c(x; X) for all contacts is both the law of fresh thresholds and their histogram (Eq. Q15).

    Attributes
    ----------
    normal : OrnsteinUhlenbeck or None
        Where `final` is a Gaussian cut at 0: the exact transition of one threshold, relaxing at the rate D/std², with
        mean and std of the normal law before the cut. A contact breaks where its threshold falls to |x| >= 0, so in
        the exact closure thresholds never go below 0. In the paper's closure the histogram of thresholds is not
        depleted there; it has the cut law and a wall at 0, which changes it by the weight below 0, finally
        ndtr(-mean/std).
        None for any other law: origins.laws.diffusion.Diffusion(final, edges) gives the motion of its weights.

    Raises InputError for a rate that is negative or not finite, and for a P_cf with atoms or gaps, where Ũ would be
    infinite; for closure "exact" also for one that jumps inside its support, and the solvers do where it begins above
    0 or ends. In the paper's closure thresholds are reflected where P_cf ends at a positive density.
    """

    def __init__(
        self, final: object, rate: float, closure: Literal["exact", "paper"] = "exact"
    ) -> None:
        self.final: Thresholds = as_thresholds(final, "final")
        self.rate = non_negative("rate", rate)
        if self.rate > 1e100:  # its powers must stay finite
            refuse("rate", rate, "must be at most 1e100; choose another unit")
        one_of("closure", closure, ("exact", "paper"))
        self.closure = closure
        self._check_potential()
        self.normal: OrnsteinUhlenbeck | None = None
        if isinstance(self.final, CutGaussian):
            mean, std = self.final.parent_mean, self.final.parent_std
            self.normal = OrnsteinUhlenbeck(mean, std, self.rate / std**2)

    def check_fresh(self, fresh: Thresholds) -> None:
        """InputError unless all fresh thresholds lie where P_cf has weight."""
        low, high = self.final.support()
        beyond = float(fresh.cdf(low)) + float(fresh.sf(high))
        if beyond > 1e-15:
            where = f"{low:g} to {high:g}, where its potential is infinite"
            fault = f"a weight of {beyond:.3g} of the fresh thresholds lies outside the final law"
            raise InputError(f"ageing: {fault}, {where}; use a final law that covers them")

    def _check_potential(self) -> None:
        """InputError where Ũ = -ln P_cf is infinite inside the support, or for the exact closure jumps."""
        atoms, corners = self.final.atoms[0], self.final.breakpoints
        if atoms.size:
            rule = "thresholds cannot diffuse to it; use a law with a density, such as gaussian"
            raise InputError(f"final: holds the single value {atoms[0]:g}: {rule}")
        gaps = np.isneginf(self.final.logpdf(0.5 * (corners[:-1] + corners[1:])))
        if gaps.any():
            low, high = corners[gaps.argmax()], corners[gaps.argmax() + 1]
            rule = "thresholds cannot diffuse across; use a law without gaps"
            raise InputError(f"final: has no weight between {low:g} and {high:g}: {rule}")
        if self.closure != "exact":
            return
        corners = corners[1:-1] if np.isfinite(self.final.support()[1]) else corners[1:]
        # log P_cf at 10,000 and 20,000 roundings of x on both sides
        around = corners + 1e4 * np.spacing(corners) * np.array([[-2.0], [-1.0], [1.0], [2.0]])
        far_below, below, above, far_above = self.final.logpdf(around)
        beside = np.maximum(np.abs(below - far_below), np.abs(far_above - above))
        for corner in corners[np.abs(above - below) > 1e-6 + 10.0 * beside]:
            rule = "there the drift of a threshold is infinite for an instant, which no solver follows yet"
            use = 'use a law without jumps inside, or closure = "paper"'
            raise InputError(f"final: the density jumps at {corner:g}: {rule}; {use}")


@dataclass(frozen=True)
class OrnsteinUhlenbeck:
    """dx = λ (mean - x) dt + std (2λ)^(1/2) dW: x(t) is normal with mean_after and std_after, given x(0) = x0.

    mean and std (lengths) are of the stationary normal law, `rate` is λ (per time). Methods take arrays that
    broadcast: values x0 (lengths) and times >= 0.
    """

    mean: float
    std: float
    rate: float

    def mean_after(self, x0: npt.ArrayLike, time: npt.ArrayLike) -> Array:
        """mean + (x0 - mean) e^(-λt), a length."""
        x0 = np.asarray(x0, dtype=float)
        return x0 - (self.mean - x0) * np.expm1(-self.rate * np.asarray(time))

    def std_after(self, time: npt.ArrayLike) -> Array:
        """std (1 - e^(-2λt))^(1/2), a length."""
        return self.std * np.sqrt(-np.expm1(-2.0 * self.rate * np.asarray(time)))

"""Ageing: the threshold of a contact that holds diffuses towards the law of old contacts (paper, Sec. V)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from origins.errors import InputError, non_negative, one_of, refuse
from origins.laws.timed_law import EXACT, LINKED, MEAN_RATE, ChangingThresholds
from origins.thresholds.gaussian import CutGaussian
from origins.thresholds.law import Array, Thresholds
from origins.thresholds.scipy_laws import as_thresholds


@dataclass(eq=False)
class Ageing(ChangingThresholds):
    """Fresh thresholds P_ci diffuse towards P_cf ~ exp(-Ũ): ∂P/∂t = D ∂_x (Ũ' + ∂_x) P (paper, Eq. B).

    final : P_cf, of contacts that have held for a long time: Thresholds or a frozen scipy.stats distribution on x >= 0.
        P_ci are the thresholds of origins.Contacts.
    rate : D, a length squared per time. 0: nothing ages.
    closure : "exact": the threshold of each contact diffuses independently, and the contact breaks where |x| meets it.
        "paper": one P_c(x; X) for all contacts is both the law of fresh thresholds and their histogram (Eq. Q15).

    Raises InputError for a rate that is negative or not finite, for a P_cf with atoms or gaps, where Ũ is infinite, and
    in the exact closure for one that jumps, begins above 0 or ends. In the paper's closure thresholds are reflected
    where it ends at a positive density.
    """

    final: Thresholds
    rate: float
    closure: Literal["exact", "paper"] = "exact"

    law = "ageing"
    begins_as_start = True

    def __post_init__(self) -> None:
        self.final = as_thresholds(self.final, "final")
        self.rate = non_negative("rate", self.rate)
        if self.rate > 1e100:  # its powers must stay finite
            refuse("rate", self.rate, "must be at most 1e100; choose another unit")
        one_of("closure", self.closure, ("exact", "paper"))
        self._check_potential()

    @property
    def normal(self) -> OrnsteinUhlenbeck | None:
        """Where `final` is a Gaussian cut at 0: the exact motion of a threshold, with mean and std before the cut.

        In the exact closure a threshold never comes to 0, as the contact breaks before. In the paper's closure there
        is a wall at 0, which changes the histogram by the weight below 0, finally ndtr(-mean/std). For any other
        final law origins.laws.diffusion.Diffusion gives the motion of weights.
        """
        if not isinstance(self.final, CutGaussian):
            return None
        mean, std = self.final.parent_mean, self.final.parent_std
        return OrnsteinUhlenbeck(mean, std, self.rate / std**2)

    @property
    def apart(self) -> dict[str, str]:
        """See TimedLaw."""
        averages = (
            'thermal: closure = "paper" averages over one P_c, and contacts that age have none'
        )
        follows = "ageing: nothing says whether k_i follows the threshold"
        return {
            "stiffness": f'{LINKED} {follows}; use "independent"',
            MEAN_RATE: f"{averages}; {EXACT}",
        }

    @property
    def further_laws(self) -> dict[str, Thresholds]:
        """See ChangingThresholds."""
        return {"final": self.final}

    def __str__(self) -> str:
        """The law without P_cf."""
        return f"Ageing(rate={self.rate:.4g})"

    def largest_threshold(self, fresh: float, share: float, duration: float) -> float:
        """See ChangingThresholds; less than one threshold in 1e17 diffuses by more than 9 standard deviations."""
        largest = max(fresh, float(self.final.isf(share)))
        return largest + (9.0 * self.normal.std if self.normal is not None else 0.0)

    def typical_threshold(self, fresh: float, duration: float) -> float:
        """See ChangingThresholds: the mean one of old contacts, if it is above that of fresh ones."""
        return max(fresh, self.final.mean())

    def check_stated(self) -> None:
        """InputError, as this is asked where the law stands in place of thresholds."""
        refuse("thresholds", self, "stands beside thresholds, as Contacts(law, ageing=Ageing(...))")

    def check_fresh(self, fresh: Thresholds) -> None:
        """InputError unless all fresh thresholds lie where P_cf has weight."""
        low, high = self.final.support()
        if (beyond := float(fresh.cdf(low)) + float(fresh.sf(high))) > 1e-15:
            fault = f"a weight of {beyond:.3g} of the fresh thresholds lies outside the final law"
            raise InputError(f"ageing: {fault}, {low:g} to {high:g}; use one that covers them")

    def _check_potential(self) -> None:
        """InputError where Ũ = -ln P_cf is infinite inside the support, or for the exact closure jumps."""
        atoms, corners = self.final.atoms[0], self.final.breakpoints
        if atoms.size:
            hint = "thresholds cannot diffuse to it; use a law with a density, such as gaussian"
            raise InputError(f"final: holds the single value {atoms[0]:g}: {hint}")
        gaps = np.isneginf(self.final.logpdf(0.5 * (corners[:-1] + corners[1:])))
        for low, high in zip(corners[:-1][gaps], corners[1:][gaps], strict=True):
            hint = "thresholds cannot diffuse across; use a law without gaps"
            raise InputError(f"final: has no weight between {low:g} and {high:g}: {hint}")
        inside = corners[(corners > corners[0]) & (corners < self.final.support()[1])]
        # log P_cf at 20,000 and 10,000 roundings of x on both sides
        around = inside + 1e4 * np.spacing(inside) * np.array([[-2.0], [-1.0], [1.0], [2.0]])
        below, across, above = np.abs(np.diff(self.final.logpdf(around), axis=0))
        jumps = inside[across > 1e-6 + 10.0 * np.maximum(below, above)]
        if self.closure == "exact" and jumps.size:
            hint = 'there no solver follows the drift; use another law, or closure = "paper"'
            raise InputError(f"final: the density jumps at {jumps[0]:g}: {hint}")
        low, high = self.final.support()
        if self.closure == "exact" and (low > 0.0 or high < np.inf):
            hint = "thresholds would be reflected; use a final law on all x > 0"
            raise InputError(f"ageing: the final law ends at {low:g} and {high:g}, where {hint}")


@dataclass(frozen=True)
class OrnsteinUhlenbeck:
    """dx = λ (mean - x) dt + std (2λ)^(1/2) dW, with the stationary normal law of mean and std (lengths).

    `rate` is λ (per time). x(t) is normal with mean_after and std_after, given x(0) = x0; arrays broadcast.
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

"""Smooth sliding: the state that no longer depends on X (paper Eqs. Q11a-Q11d)."""

from collections.abc import Callable
from copy import copy
from dataclasses import dataclass, field
from functools import partial

import numpy as np
import numpy.typing as npt

from master.numerics.polynomials import Pieces
from master.outcome import WELL, judged
from master.steady.cycle import Cycle
from master.steady.q15 import paper_steady
from master.steady.sums import is_summed, summed
from master.survival.life import Life
from master.survival.make import steady_life
from origins import Contacts, Thresholds
from origins.contacts import LAWS, check_contacts
from origins.errors import between
from origins.thresholds.law import Array
from origins.thresholds.quadrature import gauss

# Last coefficients of averages over stretches at birth, whose errors are about the square; where a survival takes long.
RESOLVED_QUICK, RESOLVED = 1e-9, 1e-7


@dataclass(frozen=True)
class SteadyState:
    """Steady sliding, whatever the start.

    force : F_k/(N_c <k>), a length. Where contacts form again at once and relaxed, and all are equally stiff, it is
        <x_b^2>/(2 <x_b>); x_b is the stretch at which a contact breaks, x_s at T = 0.
    force_error : its error in units of the mean threshold.
    holding : fraction of the contacts that hold, C/(C + v tau).
    thresholds : P_c of new contacts, or with the paper's closure of ageing of all, from a table of weights.
    mean_threshold : its mean <x_s>, a length.
    cycle_length : C, the mean travel of the slider between a contact's birth and its break, a length; its error is in
        units of the mean threshold.
    success, message : whether the relative error of the force is at most 1e-3, and the accuracy reached.
    positivity_defect : with the paper's closure of ageing the sum of the negative weights of the table of P_c, without
        the sign, which the density leaves out.
    """

    force: float
    force_error: float
    holding: float
    thresholds: Thresholds = field(repr=False)
    mean_threshold: float
    cycle_length: float
    cycle_length_error: float
    success: bool
    message: str
    _survival_at: Callable[[Array], Array] = field(repr=False)
    positivity_defect: float = 0.0

    def distribution(self, x: npt.ArrayLike) -> Array:
        """Q_s(x) per length at stretches x (paper, Eq. Q11a), of all contacts; same shape as x."""
        x = np.asarray(x, dtype=float)
        return (self._survival_at(x.ravel()) * self.holding / self.cycle_length).reshape(x.shape)[
            ()
        ]


def steady_state(contacts: Contacts, *, velocity: float = 1.0) -> SteadyState:
    """Kinetic force and stretches in steady sliding (paper, Eq. Q10).

    contacts : with any laws; the start does not matter. The paper's closure of ageing is solved only without others.
    velocity : v > 0, length per time; it matters only with rates of breaking, ageing, grains or delay.

    Raises InputError where <x_s^2>, with linked stiffness <x_s^3>, is infinite: then the force grows for ever and there
    is no steady state; and where contacts break at once.
    """
    check_contacts(contacts, "master.steady_state", LAWS, own_rates=True)
    return state_at(contacts, between("velocity", velocity, 1e-100, 1e100))


def state_at(contacts: Contacts, velocity: float, life: Life | None = None) -> SteadyState:
    """The state at a speed; a life that is given is that of `steady_life`."""
    unit = contacts.mean_threshold
    if contacts.ageing is not None and contacts.ageing.closure == "paper":
        fields = paper_steady(contacts, velocity)
    else:
        life = life or steady_life(contacts, velocity)
        if contacts.reforming and not contacts.reforming.law.is_single:
            life = copy(life)  # its owner may ask for more
            resolved = RESOLVED_QUICK if life.quick else RESOLVED
            life.coefficient_limit = max(life.coefficient_limit, resolved)
        cycle = Cycle(contacts, life, velocity)
        if is_summed(contacts):
            sums = summed(contacts, np.array([velocity]))
            if float(sums.area_error[0]) < cycle.area_error:
                cycle.length, cycle.length_error = (
                    float(sums.length[0]),
                    float(sums.length_error[0]),
                )
                cycle.area, cycle.area_error = float(sums.area[0]), float(sums.area_error[0])
        force, force_error = cycle.force()
        fields = {
            "force": force,
            "force_error": force_error / unit,
            "holding": cycle.length / cycle.birth_to_birth,
            "thresholds": contacts.thresholds,
            "mean_threshold": unit,
            "cycle_length": cycle.length,
            "cycle_length_error": cycle.length_error / unit,
            "_survival_at": partial(_survival_at, cycle),
        }
    force = max(abs(fields["force"]), float(np.finfo(float).tiny))  # F_k may be 0
    relative = fields["force_error"] * unit / force
    success, message = judged("F_k", relative, WELL)
    return SteadyState(success=bool(success), message=message, **fields)


def _survival_at(cycle: Cycle, x: Array) -> Array:
    """Of the contacts born, the share that holds when they come to the stretches x (n,), averaged over births."""
    life, births = cycle.life, cycle.born
    if births.is_single:
        since_birth = x[:, None] - births.mean()
        survival = cycle.scaled(np.maximum(since_birth, 0.0)).survival
        return np.asarray((since_birth >= 0.0) * survival)[:, 0]
    low, high = np.clip(births.span, -life.largest_stretch, life.largest_stretch)
    # twelve panels, and edges where the survival bends
    even = np.linspace(low, high, 13)
    fixed = np.concatenate([even, births.breakpoints, np.zeros(1), life.bends, -life.bends])
    cuts = np.append(np.tile(fixed, (x.size, 1)), -np.abs(x)[:, None], axis=1)
    pieces = Pieces.between(np.clip(cuts, low, np.clip(x, low, high)[:, None]))
    born, weights = gauss(pieces.low, pieces.high)
    weights *= births.pdf(born) / (births.cdf(high) - births.cdf(low))
    survival = cycle.scaled(x[pieces.owner, None] - born, born).survival
    return np.asarray(np.bincount(pieces.owner, (weights * survival).sum(axis=1), x.size), float)

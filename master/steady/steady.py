"""Smooth sliding: the state that no longer depends on X (paper Eqs. Q11a-Q11d)."""

from __future__ import annotations

from functools import partial

import numpy as np
import numpy.typing as npt

from master.lives.life import Life
from master.lives.make import steady_life
from master.motion.motion import Motion
from master.outcome import WELL, judged
from master.renewal.births import reforming_law
from master.steady.state import SteadyState
from master.steady.travel import Travel, check_finite
from origins import Contacts
from origins.contacts import LAWS, check_contacts
from origins.errors import positive
from origins.start import Start
from origins.thresholds.quadrature import gauss

Array = npt.NDArray[np.float64]


def steady_state(contacts: Contacts, *, velocity: float = 1.0) -> SteadyState:
    """Kinetic force and stretches in steady sliding (paper, Eqs. Q10, Q11c and Q11d).

    Parameters
    ----------
    contacts : Contacts
        With any laws; the start does not matter. The paper's closure of ageing is solved only
        without other laws.
    velocity : float
        v > 0, length per time; it matters only with rates of breaking, ageing, grains or delay.

    Raises InputError where <x_s^2>, with linked stiffness <x_s^3>, is infinite: then the force
    grows for ever and there is no steady state; and where contacts break at once.
    """
    check_contacts(contacts, "master.steady_state", LAWS, own_rates=True)
    velocity = positive("velocity", velocity)
    if contacts.ageing is not None and contacts.ageing.closure == "paper":
        from master.paper.q15_steady import paper_steady

        return paper_steady(contacts, velocity)
    check_finite(contacts)
    life, births = steady_life(contacts, velocity), reforming_law(contacts)
    travel = Travel(contacts, life, births, velocity)
    wait, unit = velocity * contacts.waiting_time, contacts.mean_threshold
    force, force_error = travel.force(wait)
    success, message = judged("F_k", force_error / max(abs(force), WELL * unit), WELL)
    return SteadyState(
        force=force,
        force_error=force_error / unit,
        holding=travel.length / (travel.length + wait),
        thresholds=contacts.thresholds,
        mean_threshold=unit,
        cycle_length=travel.length,
        cycle_length_error=travel.length_error / unit,
        success=bool(success),
        message=message,
        _held=partial(_held, life, births, velocity),
    )


def _held(life: Life, births: Start, velocity: float, x: Array) -> Array:
    """Share of all contacts that hold at stretches x (n,) after their birth, averaged over births."""
    low, high = np.clip(births.span, -life.reach, life.reach)
    at = x[:, None]
    born, weights = np.full((x.size, 1, 1), births.mean()), (at >= low)[..., None] * 1.0
    if not births.is_single:
        # twelve panels, and edges where the survival bends
        even = np.linspace(low, high, 13)
        fixed = np.concatenate([even, births.breakpoints, np.zeros(1), life.bends, -life.bends])
        cuts = np.append(np.tile(fixed, (x.size, 1)), -np.abs(at), axis=1)
        cuts = np.sort(np.clip(cuts, low, np.clip(at, low, high)), axis=1)
        born, weights = gauss(cuts[:, :-1], cuts[:, 1:])
        weights *= births.pdf(born) / (births.cdf(high) - births.cdf(low))
    way, rows = np.maximum(at[..., None] - born, 0.0), (-1, born.shape[-1])
    far = max(float(way.max(initial=0.0)), life.reach)
    motion = Motion(np.array([0.0, far / velocity]), np.array([0.0, far]))
    history = motion.history(way.reshape(rows) / velocity, np.zeros((1, 1)))
    held = life.left(born.reshape(rows), history)[0].reshape(born.shape)
    return np.asarray((weights * held).sum(axis=(1, 2)))

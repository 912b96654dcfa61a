"""The face of the ensemble: discrete contacts on a rigid slider, or on one that a spring pulls."""

from __future__ import annotations

from typing import Any

import numpy.typing as npt

from eq_model.ensemble import Ensemble
from origins import Contacts
from origins.drive import SlipRule


def simulate(
    contacts: Contacts,
    path: npt.ArrayLike,
    *,
    velocity: float = 1.0,
    time: npt.ArrayLike | None = None,
    spring: float | None = None,
    slip: SlipRule = "reset",
    slip_fraction: float | None = None,
    n_contacts: int = 100_000,
    n_replicas: int = 1,
    seed: int = 0,
    tolerance: float | None = None,
    wall_time: float | None = None,
    histograms: npt.ArrayLike = (),
    comm: Any = None,
    threads: int = 1,
) -> Any:  # a union would be asked which it is at each use
    """Follow n_contacts * n_replicas discrete contacts along the path of a slider, rigid or pulled through a spring.

    A contact breaks where its stretch reaches its threshold, or before where its breaking rate says so, waits where
    there is a delay, and starts again with a fresh threshold (paper, Secs. II and IV). The contacts are independent,
    so the mean is unbiased at every number of them, and each is sampled exactly, without a time step; only a threshold
    that diffuses takes steps, exact but for how the way between two of them bends (`step_error`).

    With a `spring` the contacts of one replica are coupled: the path is that of the drive, X_T, and one slider has
    K (X_T - X) = sum of k_i x_i. Every break moves it on, more may break at the same X_T, and what breaks there is one
    avalanche (eq_model.coupled; in plain Python in tests/plain_coupled.py). Delay and linked stiffness are taken, and
    contacts that form again stretched with slip "instant"; T = 0, thresholds do not change, and the drive never turns.

    Parameters
    ----------
    contacts : origins.Contacts
        With temperature and ageing (closure "exact"), delay, re-forming, linked stiffness and thresholds that grow with
        their age, each where it is there.
    path : array of shape (n,)
        Positions X (lengths, in the unit of the thresholds), from X = 0 on; it may turn round. See origins.Drive.
    velocity : float
        Speed along the path (length per time), of which only rates and delay tell.
    time : array of shape (n,), optional
        When each point is reached, instead of the velocity: for holds and velocity steps.
    spring : float, optional
        K/(N_c <k>) of a soft slider; None: it is rigid.
    slip : "reset", "reform-after" or "instant"
        With a spring, when broken contacts form again. "instant": at once. "reform-after": when the avalanche ends, or
        the delay after it. "reset": as that, but once an avalanche has broken `slip_fraction` of the contacts all are
        drawn anew, those that are out too, and the slider moves to X_T.
    slip_fraction : float, optional
        Share of a replica's contacts that an avalanche breaks at least to be told as a slip; None: 0.2. Before a slip
        avalanches break up to 2 N^(-1/3) of them, at N = 4,000 0.13.
    n_contacts, n_replicas : int
        Replicas differ in their random numbers only. Standard errors of coupled contacts are those between replicas.
    seed : int
        0 <= seed < 2^64. The result depends on these arguments alone, bit by bit, not on the number of ranks.
    tolerance : float, optional
        Largest standard error of the force wanted, in units of the mean threshold: contacts are added, twice as many
        each time, until it is reached or all n_contacts * n_replicas are followed.
    wall_time : float, optional
        Seconds after which no further block is begun: then the result does depend on the machine.
    histograms : array of int
        Indices of points of the path at which stretches and thresholds of the contacts that hold are counted, at most
        2,000 of them, of 32 kB each.
    comm : mpi4py communicator, optional
        Its ranks share the work, and all must call; None: this process alone, mpi4py not needed.
    threads : int
        Blocks of contacts that each rank follows at once, on as many cores; the result does not depend on it.

    Returns an EnsembleResult, with a spring a CoupledResult.

    Raises InputError for arguments that cannot be used, and for thresholds that cannot be tabulated.

    In plain Python: tests/plain_life.py follows one life, eq_model/closest.py is the paper's own algorithm (Sec. II).
    """
    arguments = locals()  # all of them are those of Ensemble
    ensemble = Ensemble(**arguments)
    for _ in ensemble:
        pass
    return ensemble.result()

"""The face of the ensemble: discrete contacts along the path of a rigid slider."""

from __future__ import annotations

from typing import Any

import numpy.typing as npt

from eq_model.ensemble import Ensemble
from eq_model.ensemble_result import EnsembleResult
from origins import Contacts


def simulate(
    contacts: Contacts,
    path: npt.ArrayLike,
    *,
    velocity: float = 1.0,
    time: npt.ArrayLike | None = None,
    n_contacts: int = 100_000,
    n_replicas: int = 1,
    seed: int = 0,
    tolerance: float | None = None,
    wall_time: float | None = None,
    histograms: npt.ArrayLike = (),
    comm: Any = None,
    threads: int = 1,
) -> EnsembleResult:
    """Follow n_contacts * n_replicas discrete contacts along the path of a rigid slider.

    A contact breaks where its stretch reaches its threshold, or before where its breaking rate says so, waits where
    there is a delay, and starts again with a fresh threshold (paper, Secs. II and IV). The contacts are independent,
    so the mean is unbiased at every number of them, and each is sampled exactly, without a time step; only a threshold
    that diffuses takes steps, exact but for how the way between two of them bends (`step_error`).

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
    n_contacts, n_replicas : int
        Replicas differ in their random numbers only.
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

    Raises InputError for arguments that cannot be used, and for thresholds that cannot be tabulated.

    plain.py follows one life in plain Python; closest.py is the paper's own algorithm.
    """
    ensemble = Ensemble(
        contacts,
        path,
        velocity=velocity,
        time=time,
        n_contacts=n_contacts,
        n_replicas=n_replicas,
        seed=seed,
        tolerance=tolerance,
        wall_time=wall_time,
        histograms=histograms,
        comm=comm,
        threads=threads,
    )
    for _ in ensemble:
        pass
    return ensemble.result()

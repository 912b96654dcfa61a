"""`simulate`: discrete contacts on a rigid slider, or on one that a spring pulls."""

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
    slip: SlipRule | None = None,
    mass: float | None = None,
    damping: float = 0.0,
    slip_fraction: float | None = None,
    n_contacts: int = 100_000,
    n_replicas: int = 1,
    seed: int = 0,
    tolerance: float | None = None,
    wall_time: float | None = None,
    histograms: npt.ArrayLike = (),
    comm: Any = None,
    threads: int = 1,
) -> Any:  # with a union, every caller would have to test which it is
    """Follow n_contacts * n_replicas discrete contacts along the path of a slider, rigid or pulled through a spring.

    A contact breaks where its stretch reaches its threshold, or earlier at its breaking rate, is out for the delay if
    there is one, and re-forms with a fresh threshold (paper, Secs. II and IV). The contacts are independent, so the
    mean is unbiased at every number of them, and each is sampled exactly, without a time step; only a threshold that
    diffuses takes steps, with the error `step_error`. For intervals use the result's `force_error`, which holds both.

    With a `spring` the contacts of one replica are coupled: the path is that of the drive, X_T, and one slider has
    K (X_T - X) = sum of k_i x_i. Every break moves the slider, so that more contacts may break; all that break at one
    X_T make an avalanche (eq_model.coupled; in plain Python in tests/plain_coupled.py). Then of the laws heat, delay,
    strengthening and linked stiffness are possible, and with slip "instant" and no delay re-forming stretched. Heat is
    exact, too: breaks are proposed at rates above the contacts' own, and thinned. With a mass the drive
    must not turn, and contacts re-form relaxed.

    Parameters
    ----------
    contacts : origins.Contacts
        With any of temperature and ageing (closure "exact"), delay, re-forming, linked stiffness and thresholds that
        grow with age.
    path : array of shape (n,)
        Positions X (lengths, in the unit of the thresholds), from X = 0 on; it may turn round. See origins.Drive.
    velocity : float
        Speed along the path (length per time); only rates, ageing, growing thresholds and delay depend on it.
    time : array of shape (n,), optional
        When each point is reached, instead of the velocity: for holds and velocity steps.
    spring : float, optional
        K/(N_c <k>) of a soft slider; None: it is rigid.
    slip : "reset", "reform-after" or "instant"
        With a spring, when broken contacts re-form; left out, "reset". "instant": at once. "reform-after": when the
        avalanche ends, or one delay later. "reset": the same, but once an avalanche has broken `slip_fraction` of the
        contacts, all contacts, those that are out too, are replaced by fresh relaxed ones, and the slider moves to X_T.
    mass, damping : float, optional
        M/(N_c <k>) (time squared) and γ/(N_c <k>) (time) of a soft slider, M X'' + γ X' = K (X_T - X) - F, instead of a
        slip rule. Contacts form again relaxed where the slider then is, at once or after their delay. It starts at rest
        at X = 0 and X_T = F(0)/K.
    slip_fraction : float, optional
        Smallest share of a replica's contacts that breaks in an avalanche that counts as a slip (with a mass, of those
        that held, in a swing down of the spring's force); None: 0.2. Before a slip avalanches break up to 2 N^(-1/3) of
        them, 0.13 at N = 4,000.
    n_contacts, n_replicas : int
        Replicas differ in their random numbers only. Standard errors of coupled contacts are those between replicas.
    seed : int
        0 <= seed < 2^64. The result depends on these arguments alone, bit by bit, not on the number of ranks.
    tolerance : float, optional
        Largest standard error of the force, in units of the mean threshold: the number of contacts is doubled until it
        is reached or all n_contacts * n_replicas are followed.
    wall_time : float, optional
        Seconds after which no further block is begun, and on a spring replicas are given up on their way; the result
        then depends on the machine.
    histograms : array of int
        Indices of points of the path at which stretches and thresholds of the contacts that hold are counted; at most
        2,000, of 32 kB each.
    comm : mpi4py communicator, optional
        Its ranks share the work, and all must call; None: this process alone, mpi4py not needed.
    threads : int
        Blocks of contacts that each rank follows at once, on as many cores; the result does not depend on it.

    Returns an EnsembleResult, with a spring a CoupledResult, with a mass a HeavyResult.

    Raises InputError for arguments that cannot be used, for thresholds that cannot be tabulated, and where `wall_time`
    is over before one replica on a spring has reached the end of the path.

    Plain Python twin: eq_model/closest.py, the paper's algorithm (Sec. II).
    """
    ensemble = Ensemble(
        contacts,
        path,
        velocity=velocity,
        time=time,
        spring=spring,
        slip=slip,
        mass=mass,
        damping=damping,
        slip_fraction=slip_fraction,
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

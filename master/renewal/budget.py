"""The error budget: how the tolerance of `solve` is divided among panels, births, survivals and round-off."""

from dataclasses import dataclass

from master.survival.life import Life

# Loosest tolerance of a solution, in mean thresholds. Panels to a looser one may be so wide that their check points
# step over the peak of breaks of narrow thresholds, and estimate a third of the true error (measured at 1e-2).
LOOSEST = 1e-3
# Part of the tolerance that panels keep where survivals and round-off take more. The tolerance is missed there, which
# force_error says; panels without any part would only be halved for nothing.
LEAST_FOR_PANELS = 0.4
# Part of what panels get that is kept back where a survival is a sum: its error is known only when it is returned.
FOR_SUMS = 0.2
# Smallest tolerance of a panel, a share of the contacts. Conservation is rounded at 1e-15, the survival of a law of
# scipy at some 1e-14; survivals that are sums are rounded by some 1e-13, the second.
SMALLEST_TOLERANCE, SMALLEST_OF_SUMS = 3e-14, 4.5e-13
# Tolerance of a piece of the births, in that of a panel, which sums some hundred integrals over births; and the
# smallest, the rounding of conservation.
FOR_BIRTHS, SMALLEST_FOR_BIRTHS = 3e-3, 1e-15


@dataclass(frozen=True)
class ErrorBudget:
    """The parts of a tolerance, beside which `solve_rigid` adds up force_error:

        force_error = round_off + (survivals + worst panel + births + left out) * stretch/mean.

    | part | measured by | its part of the tolerance | along the path |
    |---|---|---|---|
    | round-off | `round_off` in `master/rigid.py`, from the path | taken off first | one for all |
    | survivals | each query of a life (`Survivors.error`) | what is known beforehand is taken off, too | the largest |
    | panels | residuals between the nodes (`Batch.error`) | the rest, 0.4 of all or more (sums: 0.32) | the largest |
    | births | what sums leave out (`Past.worst_sum_error`) | 0.003 of a panel's for each piece, on top | the largest |
    | left out | contacts of earlier legs (`Past.left_out`) | 3e-6 of a panel's for each leg, on top | adds up |

    All but round-off are shares of the contacts, and that is in mean thresholds: an error of the number of contacts
    that hold counts as one of the force by stretch/mean, the longest stretch that a contact can have over the mean
    threshold. Errors of panels are not summed along the path: conservation fixes the number on each anew. The start
    is one of the survivals, and has no part of its own. Where survivals are sums, panels get 1 - FOR_SUMS = 0.8 of
    the rest, as errors of these are known later: at least 0.32 of all.

    "On top" is outside of the tolerance: round-off, survivals and panels may use up all of it, and births and left
    out are added. Nothing is set aside for them because both are asked of each piece of a sum, and of each leg, and
    how many there will be nobody knows beforehand; and because they are little. With heat both are COARSER = 30
    times as much, 0.09 and 9e-5 of a panel's (past.py), as a survival takes long; with ageing the second is, and
    pieces have one length. On 32 random paths of three to five legs the estimated error of all births was at most
    1.5e-3 of a panel's part without heat (median 1e-7), and 0.06 of it with heat (median 5e-3). What they come to is
    in force_error, and where that is above the tolerance, `success` is False.

    These errors see what numbers do, and no fault of bookkeeping: a survival, a birth or a panel that is counted twice
    or not at all conserves the number as well, unless it jumps. So that panels leave no gap is checked as they are
    kept (SolvedPanels.append), that no more contacts hold than there are at the end (outcome.unconserved), and all else
    by tests, beside the plain twin and the ensemble.

    The error is inf where the four shares, all but round-off, exceed 0.1 together (RESOLVED in master/rigid.py). A
    tolerance below that of rounded positions is raised to it (`finest` there), and force_error stays above what was
    asked for. A march that ends early, as breaks are steady, adds AGREE = 0.25 of a panel's part to its last panel,
    for the changes that it does not follow (master/renewal/march.py).

    panels : largest error of a panel, a share of the contacts: that of the number of breaks, plus that of the force
        divided by the longest stretch (Batch.error)
    births : of a piece of the births on earlier legs, a share of the contacts: the first coefficient that its
        polynomial leaves out, times the births on the piece, times the number of legs that count
    survivals, round_off : what was taken off first: the error of a survival that is known before, a share of the
        contacts, and that of the force by rounding, in mean thresholds. They are kept to be read, and steer nothing.
    """

    panels: float
    births: float
    survivals: float
    round_off: float

    @classmethod
    def divide(
        cls, tolerance: float, life: Life, round_off: float, stretch: float, mean: float
    ) -> "ErrorBudget":
        """Divide a tolerance of the force, which is in mean thresholds, as round_off is; stretch, mean : the longest
        stretch and the mean threshold (lengths). A tolerance looser than LOOSEST counts as that."""
        tolerance = min(tolerance, LOOSEST)
        fixed_errors = round_off + life.error * stretch / mean
        part = max(tolerance - fixed_errors, LEAST_FOR_PANELS * tolerance)
        if not life.quick:
            part *= 1.0 - FOR_SUMS
        smallest = SMALLEST_TOLERANCE if life.quick else SMALLEST_OF_SUMS
        panels = max(part * mean / stretch, smallest)
        return cls(panels, max(FOR_BIRTHS * panels, SMALLEST_FOR_BIRTHS), life.error, round_off)

"""Life: what the master equation uses of the laws of contacts; and that of contacts without heat."""

from typing import NamedTuple

import numpy as np

from master.motion import History, middle_of
from master.numerics.averages import integrals
from master.numerics.polynomials import Pieces, Rows
from master.numerics.table import Table
from master.outcome import stop_after
from origins import Contacts, InputError
from origins.start import Start
from origins.thresholds.law import Array
from origins.thresholds.quadrature import finite_density, panel_edges

# Last two Legendre coefficients below which pieces of the stretches at birth, and panels of the mean rate H, are not
# halved, where no tolerance is known.
COEFFICIENT_LIMIT = 1e-9
# Survivals below this count as 0, and those within it of 1 as 1: a hundredth of the rounding of sums of them.
NO_SURVIVAL = 1e-18
# An exact threshold within this relative distance above |x| counts as met: a turning point placed
# exactly at it may be off by rounding.
TIE = 1e-12
# Relative distance from an exact threshold within which rounding may put |x| on its wrong side.
ROUNDED_SIDE = 1e-9
# Fraction of the contacts that counts as few: below it the error of a survival is told in parts of itself, as the few
# that hold are stretched far. Sums over thresholds are halved until their errors are small beside it.
FEW = 1e-4
# Factor on the largest measured error of an integral: halving shows only two thirds of the error where
# the integrand begins as a square root, and only some integrals are measured.
MARGIN = 4.0
# The least threshold (a length) at which a rate is evaluated: no rate is defined at a threshold of 0.
SMALLEST = 1e-100
# Thresholds below this many mean thresholds underflow in sums; and the largest weight that may lie there.
LOWEST, MOST_BELOW_LOWEST = 1e-290, 1e-12
# Survival of P_c at which panels for sums over thresholds end: e^-69, which not even the stiffest contacts outweigh.
PANELS_END = 1e-30
# Accuracy of the table of survivals weighted by stiffness, of which K is made where stiffness is linked; and its
# narrowest panel, in mean thresholds: beside a density that diverges halving ends there.
OF_LINKED, NARROWEST_OF_LINKED = 1e-12, 1e-9
# Weight of exact thresholds, short of 1, from which on the rest is their rounding and no spread of thresholds.
ALL_ATOMS = 1.0 - 1e-14


class Survivors(NamedTuple):
    """The fraction of contacts born together that still holds, and its force; arrays of one shape.

    survival : E, the fraction that still holds, between 0 and 1
    force : K, the mean force per contact born, in units of <k>: a length
    error : estimate from above of the largest error of these survivals, which finer panels do not reduce
    """

    survival: Array
    force: Array
    error: float

    @property
    def both(self) -> Array:
        """Survival and force as one array, whose first axis has the length 2."""
        return np.stack([self.survival, self.force])

    def reshape(self, *shape: int) -> "Survivors":
        """The same in arrays of another shape."""
        return Survivors(self.survival.reshape(shape), self.force.reshape(shape), self.error)


class Life:
    """Survival and force, after any motion of the slider, of contacts that were born together.

    The method `survival_and_force` gives the survival E(t, s) and the force K(t, s) of number conservation for
    contacts born at the stretches at which broken contacts re-form, and G_0(t) and M_0(t) for contacts
    born at t = 0 at the stretches of the start. Each law of contacts is a subclass; attributes that it
    does not set are those of a survival that depends on time and has no bends.

    largest_stretch : length; a contact whose |x| has been beyond it no longer holds (its survival is below 1e-17)
    safe_stretch : length; a contact whose |x| has never been beyond it still holds (its survival is 1 to
        rounding); 0 where there is no such length
    largest_birth_stretch : length; stretches of the start beyond it are left out
    atoms : array of shape (n,), exact thresholds (lengths), at which finite fractions of contacts break together
    bends : array of shape (n,), sorted lengths: the largest |x| at which the survival of a contact is not
        smooth, such as jumps of P_c and exact thresholds
    peaks_at_bends : whether, of births on a leg before a turn, survivals are largest where it ends, or where the
        largest |x| bends; where thresholds change, they may be largest anywhere, and be 0 on both sides
    marks : array of shape (n,), where `quick`: |x| between which the survival is nearly a polynomial
    resolution_length : length over which the survival has to be resolved
    quick : whether `survival_and_force`, for births at one stretch, is asked itself, and no table of it is made
    pair_work : work of `survival_and_force` for one birth at one instant, in look-ups in a table; 1 if it is no sum
    timeless : whether the survival depends only on the distance moved, and not on the time that it took
    error : the least error of a survival that `survival_and_force` can return; each query returns its own, too
    neglected, error_is_relative : see `error_at`
    error_of_force : further error of K, in units of the stretches at a break; only transforms need it
    coefficient_limit : last coefficients, on a piece of the stretches at birth, below which it is not halved
    start_as_births : whether contacts of the start survive as those born later at the same stretch
    has_strands : whether births of earlier legs have to be followed, since `survival_and_force` does not know them
    no_density : why Q(x;X) is not known on paths of several legs; "" where it is
    until : reading of time.monotonic() after which averages over stretches at birth raise StoppedError
    """

    largest_stretch: float
    resolution_length: float
    safe_stretch = 0.0
    largest_birth_stretch = np.inf
    quick = False
    timeless = False
    has_strands = False
    peaks_at_bends = True
    no_density = ""
    until = np.inf
    start_as_births = True
    pair_work = 1
    error = 0.0
    neglected = 0.0
    error_is_relative = True
    error_of_force = 0.0
    coefficient_limit = 1e-12
    atoms: Array = np.empty(0)
    bends: Array = np.empty(0)
    marks: Array = np.empty(0)

    def atom_fraction(self, atom: float, stretch: float) -> float:
        """Upper bound of the fraction of contacts born at a stretch that have the exact threshold `atom`."""
        return 0.0

    def error_at(self, survival: Array, error: float) -> Array:
        """Error of each survival, if `error` is the largest of any survival; same shape.

        Integrals of E over all lags, and transforms even more, need it where few contacts hold; a march needs the
        largest one alone. A survival that is closed, or a sum for each lag by itself, is known to a part of itself
        where few hold, but for the contacts that it leaves out, `neglected` of all. One that follows from the flow of
        those that broke before (`error_is_relative` is False: ageing) is a difference from 1, with one error at all
        lags.
        """
        if not self.error_is_relative:
            return np.full(survival.shape, error)
        return error * np.minimum(survival / FEW, 1.0) + self.neglected

    def rounded_away(self, velocity: float) -> Array:
        """Bounds of what rounding of the survival hides in the integrals of E and K over the distance since birth, at a
        speed, lengths to the powers 1 and 2; shape (2,)."""
        return np.zeros(2)

    def survival_and_force(self, born: Start | Array, history: History) -> Survivors:
        """The fraction of contacts that still holds, its force per contact born, and the error of the fraction.

        born : the law of the stretches at birth, or an array of single stretches that broadcasts
            with the history; thresholds follow P_c conditional on x_s > |stretch|
        history : of shape (rows, columns); each row lies within one smooth piece, see History

        Returns arrays of shape (rows, columns).
        """
        shape = history.now.shape
        if isinstance(born, Start) and not born.is_single:
            return self._averaged(born, history.pick(slice(None))).reshape(*shape)
        single = born.mean() if isinstance(born, Start) else born
        stretch = np.broadcast_to(single, shape).ravel()
        moves = history.pick(slice(None))
        side = np.repeat(middle_of(moves.largest(stretch).reshape(shape)), shape[1])
        return self.survivors(stretch, side, moves).reshape(*shape)

    def survivors(self, born: Array, side: Array, history: History) -> Survivors:
        """Those of contacts with these moves (n,), born at these stretches (n,). The largest |x| `side`, shape (n,),
        decides which exact thresholds are passed."""
        raise NotImplementedError

    def _averaged(self, law: Start, history: History) -> Survivors:
        """Survivors averaged over the law's stretches, of moves of shape (n,). Pieces of the law end where x is 0, and
        where the largest |x| changes sides or meets a bend."""
        first, last = np.clip(law.span, -self.largest_birth_stretch, self.largest_birth_stretch)
        furthest = self.largest_stretch if max(-first, last) <= self.largest_stretch else np.inf
        bends = np.append(self.bends, furthest)
        fixed = np.concatenate([np.linspace(first, last, 7), law.breakpoints, [0.0], bends, -bends])
        now, high, low = (part[:, None] for part in (history.now, history.high, history.low))
        moving = [-now, -high, -low, -0.5 * high, -0.5 * low, -0.5 * (high + low)]
        cuts = [np.tile(fixed, (now.size, 1)), *moving, bends - high, -bends - low]
        pieces = Pieces.between(np.clip(np.concatenate(cuts, axis=1), first, last))
        middle = 0.5 * (pieces.low + pieces.high)
        pieces = pieces.pick(history.pick(pieces.owner).largest(middle) < furthest)
        weight = law.cdf(self.largest_birth_stretch) - law.cdf(-self.largest_birth_stretch)

        survival_errors = [self.error]

        def weighted(row: Rows, born: Array) -> Array:
            stop_after(self.until)
            nodes = born.shape[1]
            side = history.pick(row).largest(middle_of(born)[:, 0])
            moves = history.pick(np.repeat(row, nodes))
            found = self.survivors(born.ravel(), np.repeat(side, nodes), moves)
            survival_errors.append(found.error)
            return found.both.reshape(2, *born.shape) * (finite_density(law, born) / weight)

        # densities of a law far narrower than its distance from 0 are rounded
        rounding = 100.0 * np.finfo(float).eps * max(abs(first), abs(last)) / (last - first)
        found = integrals(weighted, pieces, now.size, max(self.coefficient_limit, rounding))
        average_error = MARGIN * float(found.missed[0].max(initial=0.0))
        survival, force = found.value
        return Survivors(survival, force, max(survival_errors) + average_error)


class LawLife(Life):
    """A Life of contacts whose thresholds stay as P_c gave them.

    law : P_c; atom_weights : array of shape (n,), of its exact thresholds `atoms`
    panels : array of shape (n,), edges of panels on which 8 nodes sum P_c and x_s P_c; none where there are only atoms
    """

    def __init__(self, contacts: Contacts) -> None:
        """Find how far contacts may be stretched, where their survival bends, and how finely it varies."""
        law = self.law = contacts.thresholds
        self.error_of_force = OF_LINKED if contacts.stiffness == "linked" else 0.0
        self.atoms, self.atom_weights = law.atoms
        # a contact born in the far tail has a threshold even farther out
        births = [contacts.start] + ([contacts.reforming.law] if contacts.reforming else [])
        at_birth = float(law.sf(max(abs(end) for born in births for end in born.span)))
        furthest = float(law.isf(NO_SURVIVAL * max(at_birth, 1e-280)))  # less underflows
        self.largest_stretch = max([min(float(law.support()[1]), furthest), *self.atoms])
        marks = np.concatenate([law.breakpoints, self.atoms])
        self.bends = np.unique(marks[(marks > 0.0) & (marks <= self.largest_stretch)])
        is_spread = float(self.atom_weights.sum()) < ALL_ATOMS
        edges: Array = panel_edges(law, tail=PANELS_END) if is_spread else np.empty(0)
        self.panels: Array = np.maximum(edges, SMALLEST)
        inner = self.panels[self.panels < self.largest_stretch]
        broken = -np.diff(law.sf(inner))
        self.resolution_length = self.largest_stretch
        if broken.any():
            self.resolution_length = float(np.average(np.diff(inner), weights=broken))

    def atom_fraction(self, atom: float, stretch: float) -> float:
        """See Life; an upper bound, as heat may break some before."""
        return float(self.atom_weights[self.atoms == atom].sum() / self.law.sf(abs(stretch)))

    def threshold_survival(self, m: Array, side: Array) -> Array:
        """Survival at m, shape (n,); exact thresholds close to m are broken where they lie below `side`."""
        out = np.asarray(self.law.sf(m), dtype=float)
        for position, weight in zip(self.atoms, self.atom_weights, strict=True):
            is_near = np.abs(m - position) <= ROUNDED_SIDE * position
            furthest = np.where(is_near, side, m)
            holds = np.less(furthest, position * (1.0 - TIE)).astype(float)
            out = out + weight * (holds - np.less(m, position))
        return out


class ColdLife(LawLife):
    """Contacts that break only at their thresholds, T = 0: E = S(m)/S(|r|), m the largest |x| so far
    (paper, Eq. Nik04); a Life."""

    timeless = True

    def __init__(
        self, contacts: Contacts, coefficient_limit: float = Life.coefficient_limit
    ) -> None:
        """Find where the survival bends; InputError where P_c has weight too near to 0."""
        law = contacts.thresholds
        self.quick, self._mean = law.asked_itself, contacts.mean_threshold
        self.coefficient_limit = coefficient_limit
        beneath = float(law.cdf(LOWEST * self._mean))
        if beneath > MOST_BELOW_LOWEST:
            fault = f"a weight of {beneath:.2g} lies below {LOWEST:g} of the mean"
            hint = "where floating point ends; leave such contacts out and count them apart"
            raise InputError(f"thresholds: {fault}, {hint}")
        super().__init__(contacts)
        self.resolution_length *= 0.5  # a first guess: no heat smooths the survival
        # a narrow law breaks only between `safe_stretch` and `largest_stretch`
        self.safe_stretch = min([float(law.support()[0] or law.ppf(NO_SURVIVAL)), *self.atoms])
        lengths = [0.0, self.safe_stretch, self.largest_stretch]
        edges = np.unique(np.concatenate([lengths, self.bends, self.panels]))
        self.marks = edges[edges <= self.largest_stretch]
        # where a start reaches into a heavy tail, the few contacts beyond may carry much force
        if self.largest_stretch == law.support()[1]:
            self.largest_birth_stretch = self.largest_stretch
        self._survival_table: Table | None = None  # where stiffness is linked
        if contacts.stiffness == "linked":
            shortest = NARROWEST_OF_LINKED * self._mean
            edges, accuracy = self.marks, self.error_of_force
            self._survival_table = Table(lambda x: law.sf(x)[None], edges, accuracy, shortest)

    def _weighted_by_stiffness(self, m: Array, survival: Array) -> Array:
        """The survival at m with each contact counted k_i/<k> times: where the stiffness is linked,
        <x_s; x_s > m>/<x_s>, which by parts is m times the survival, and its integral beyond m, over <x_s>."""
        table = self._survival_table
        if table is None:
            return survival
        beyond = table.integrals()[0] - table.up_to(np.minimum(m, self.largest_stretch))
        # thresholds lie below `largest_stretch`: in the far tail this bound is more accurate than the table
        largest = np.maximum(self.largest_stretch - m, 0.0) * survival
        return np.asarray((m * survival + np.clip(beyond, 0.0, largest)) / self._mean)

    def survivors(self, born: Array, side: Array, history: History) -> Survivors:
        """See Life."""
        first = np.abs(born)
        m = history.largest(born)
        at_birth, now = np.ones((2, *m.shape))
        for survival, x, edge in ((at_birth, first, first), (now, m, side)):
            # up to `safe_stretch` all contacts hold: the law need not be evaluated there
            some = x > self.safe_stretch * (1.0 - 2.0 * TIE)
            survival[some] = self.threshold_survival(x[some], edge[some])
        force = self._weighted_by_stiffness(m, now) * (born + history.now)
        out = np.stack([now, force])
        survival, force = np.divide(out, at_birth, out=np.zeros_like(out), where=at_birth > 0.0)
        return Survivors(survival, force, self.error)

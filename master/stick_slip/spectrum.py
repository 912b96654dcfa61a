"""How F(X) decays to the kinetic force: the leading roots of D, their amplitudes, and their sum.

F - F_k ~ sum over pairs of roots of Re[c_n e^(s_n X)], c_n = 2 K^(s_n) e^(-s_n d) [1/s_n - G_0^(s_n)] / D'(s_n).
"""

import time
from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np
import numpy.typing as npt

from master.numerics import polynomials
from master.steady.cycle import Cycle
from master.stick_slip.extremes import cycle_table, forward_march
from master.stick_slip.roots import BROAD, crowding, deepest_wave, leading_roots
from master.stick_slip.transform import Complex, Transform
from origins import Contacts, InputError
from origins.brief import brief
from origins.contacts import LAWS, check_contacts
from origins.errors import between, refuse, whole
from origins.thresholds.law import Array
from origins.thresholds.tail import tail_rate

# Tolerance of E and of F, with which the sum of the terms is compared.
TOLERANCE = 1e-9
# Mean distances from birth to birth over which the sum of the terms is compared with F.
COMPARED_OVER = 6.0
# Relative rounding of an amplitude, a product of some sums.
ROUNDING = 1e-14
# Rate at which roots crowd, times the mean distance from birth to birth, below which exact values leave no slowest
# root.
LEAST_CROWDING = 1e-2
# Ratio of the delay's travel to the mean distance from birth to break beyond which roots crowd everywhere.
LONGEST_DELAY = 400.0


@dataclass(frozen=True)
class DecoherenceSpectrum:
    """Leading roots, one of each pair, slowest first; arrays of shape (n,). n is 0 where no oscillation decays as
    slowly as `beyond`, as where heat breaks contacts long before x_s.

    roots : s_n with Im s_n > 0, per length; period, decay_length : 2π/Im s_n and -1/Re s_n, lengths.
    amplitude : c_n, lengths; errors of these four are absolute, in the same units.
    kinetic_force : F_k/(N_c <k>), a length; its error is in units of the mean threshold.
    beyond : decay length (a length) of the terms left out, and so of `force_error`; that of further roots may be
        shorter.
    run_time : s.
    """

    roots: Complex
    roots_error: Array
    amplitude: Complex
    amplitude_error: Array
    decay_length_error: Array
    kinetic_force: float
    kinetic_force_error: float
    beyond: float
    run_time: float
    _unit: float = field(repr=False)
    _left_out: float = field(repr=False)

    __repr__ = brief

    @property
    def period(self) -> Array:
        return 2.0 * np.pi / self.roots.imag

    @property
    def period_error(self) -> Array:
        return self.period * self.roots_error / self.roots.imag

    @property
    def decay_length(self) -> Array:
        return -1.0 / self.roots.real

    def force(self, x: npt.ArrayLike) -> Array:
        """F_k and the sum of the terms at positions X >= 0 (lengths); same shape."""
        terms = self.amplitude * np.exp(np.multiply.outer(np.asarray(x, dtype=float), self.roots))
        return (self.kinetic_force + terms.sum(axis=-1).real)[()]

    def force_beside(self, x: Array, further: Array) -> Array:
        """As `force` at each of the positions x and so far beyond each, shape (x.size, further.size): waves there are
        products of those at x and of those at `further`."""
        near = self.amplitude * np.exp(np.multiply.outer(x, self.roots))
        return np.asarray(
            self.kinetic_force + (near @ np.exp(np.multiply.outer(self.roots, further))).real
        )

    def force_error(self, x: npt.ArrayLike) -> Array:
        """Its error at those positions in units of the mean threshold; same shape.

        An estimate: the terms left out are taken from F, solved over the first few mean distances from birth to birth,
        and extrapolated as e^(-X/beyond).
        """
        x = np.asarray(x, dtype=float)
        size = np.exp(np.multiply.outer(x, self.roots.real))
        # an error of the phase changes a wave by at most twice its size
        drift = np.minimum(np.multiply.outer(x, self.roots_error), 2.0)
        off = (size * (self.amplitude_error + np.abs(self.amplitude) * drift)).sum(axis=-1)
        with np.errstate(under="ignore"):
            off = off + self._left_out * np.exp(-x / self.beyond)
        return (off / self._unit + self.kinetic_force_error)[()]

    def compared_with(self, x: Array, force: Array, error: Array | float = 0.0) -> Self:
        """The same, with the terms that are left out estimated from F (lengths) at positions x, known to `error`."""
        apart = np.abs(force - self.force(x))
        significant = apart > 3.0 * error
        # twice as much, as the terms left out may add up in phase elsewhere
        remainder = 2.0 * apart * np.exp(np.minimum(x / self.beyond, 700.0))
        return replace(self, _left_out=float(remainder[significant].max(initial=0.0)))

    def complete_from(self, x: float, least: float) -> float:
        """The position >= x from which on terms that are left out are below `least` (lengths)."""
        left_out = self._left_out * np.exp(-x / self.beyond)
        return x + self.beyond * float(np.log(max(left_out / least, 1.0)))

    def from_place(self, x: float, least: float) -> Self:
        """The same of positions from x on alone, without the terms that are below `least` there (lengths)."""
        lasts = np.abs(self.amplitude) * np.exp(x * self.roots.real) > least
        names = "roots", "roots_error", "amplitude", "amplitude_error", "decay_length_error"
        return replace(self, **{name: getattr(self, name)[lasts] for name in names})


def decoherence_spectrum(
    contacts: Contacts, *, velocity: float = 1.0, n_roots: int = 8
) -> DecoherenceSpectrum:
    """The slowest terms of F(X) - F_k of contacts that a rigid slider moves forward.

    contacts : with any laws but the paper's closure of ageing; the start matters.
    velocity : v > 0, length per time; it matters only with heat, ageing, grains or a delay.
    n_roots : number of roots; fewer are returned where fewer are found: the search ends before the decay rate of the
        law's tail, and before that near which the infinitely many roots of exact values crowd. It includes periods
        down to 1/300 of the mean distance from birth to birth.

    Raises InputError for exact values alone, or nearly so, whose roots come as near to Re s = 0 as one likes; for tails
    slower than any exponential; for lives of 10,000 means; for waits above 400 of them; and as `steady_state` does.
    """
    began = time.perf_counter()
    check_contacts(contacts, "master.decoherence_spectrum", LAWS, own_rates=True)
    velocity, n_roots = between("velocity", velocity, 1e-100, 1e100), whole("n_roots", n_roots, 1)
    cycle = cycle_table(contacts, velocity, TOLERANCE)
    spectrum = leading_terms(cycle, n_roots)
    return replace(_with_remainder(cycle, spectrum), run_time=time.perf_counter() - began)


def leading_terms(cycle: Cycle, n_roots: int | None = None) -> DecoherenceSpectrum:
    """The slowest terms of the cycle's contacts, with nothing said about those that are left out. `n_roots` None: all
    that fade within some two mean distances from birth to birth or more slowly, and that are found together."""
    contacts, start = cycle.contacts, cycle.contacts.start
    wait, unit = cycle.wait, contacts.mean_threshold
    transform = Transform(cycle, _deepest(cycle))
    roots, searched = leading_roots(transform, (n_roots or 0) + 1)
    s = roots[:n_roots]
    next_decay = float(-roots[s.size].real) if roots.size > s.size else searched
    root_error = transform(s).root_error()
    beside = np.append(s, s + root_error)
    values = first = transform(beside)
    # at X = 0 contacts may be older than those just formed, at the same stretch, too
    if contacts.older_at_start or not (start.is_single and start.span == cycle.born.span):
        from_start = Cycle(contacts, cycle.life, cycle.velocity, born=start)
        first = Transform(from_start, -float(s.real.min(initial=0.0)))(beside)
    late = np.exp(-beside * wait) * (1.0 / beside - first.survival)
    amplitude, moved = np.split(2.0 * values.force * late / values.slope, 2)
    relative = values.force_error / np.abs(values.force) + ROUNDING
    relative += first.survival_error / np.abs(1.0 / beside - first.survival)
    kinetic, kinetic_off = cycle.force()
    return DecoherenceSpectrum(
        roots=s,
        roots_error=root_error,
        amplitude=amplitude,
        amplitude_error=np.abs(amplitude) * relative[: s.size] + np.abs(moved - amplitude),
        decay_length_error=root_error / s.real**2,
        kinetic_force=kinetic,
        kinetic_force_error=kinetic_off / unit,
        beyond=1.0 / next_decay if next_decay else np.inf,
        run_time=0.0,
        _unit=unit,
        _left_out=0.0,
    )


def _deepest(cycle: Cycle) -> float:
    """The decay rate to which roots are searched; InputError where none can be resolved."""
    contacts, wait = cycle.contacts, cycle.wait
    if wait > LONGEST_DELAY * cycle.length:
        why = "" if contacts.changing is None else contacts.changing.waiting
        fault = f"{why}contacts wait for {wait / cycle.length:.3g} times as long as they hold"
        refuse("velocity", cycle.velocity, f"{fault}; roots are told to {LONGEST_DELAY:g} times")
    crowd, tail = crowding(cycle), tail_rate(contacts.thresholds)[0]
    if crowd * cycle.birth_to_birth < LEAST_CROWDING:
        fault = "so much of their weight is in exact values alone: their roots come as near to Re s = 0 as one likes"
        hint = "and none is the slowest; give each a width, or follow F(X) with master.solve"
        raise InputError(f"thresholds: {fault}, {hint}")
    if tail == 0.0:
        fault = "the tail falls slower than any exponential, and with it F - F_k: no root exists"
        raise InputError(f"thresholds: {fault}")
    if cycle.longest > BROAD * cycle.length:
        fault = f"contacts live for all lengths up to {cycle.longest / cycle.length:.1g} times the mean: among so"
        hint = "many no leading oscillating wave can be resolved; master.propensity tells X*, or that it is unknown"
        raise InputError(f"contacts: {fault} {hint}")
    return deepest_wave(cycle, min(tail, crowd))


def _with_remainder(cycle: Cycle, spectrum: DecoherenceSpectrum) -> DecoherenceSpectrum:
    """The terms beside F, solved over COMPARED_OVER mean distances from birth to birth."""
    horizon = COMPARED_OVER * cycle.birth_to_birth + max(-2.0 * cycle.contacts.start.span[0], 0.0)
    march = forward_march(cycle, horizon, TOLERANCE).run()
    relative = np.append(0.0, polynomials.NODES)
    solved = march.solved
    x = cycle.velocity * (solved.begin[:, None] + solved.width[:, None] * relative)
    off = (solved.error + march.unseen_error) * march.longest_stretch
    return spectrum.compared_with(x, solved.force, off[:, None])

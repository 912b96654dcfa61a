"""How F(X) decays to the kinetic force: the leading roots, what each carries, and the sum of them.

With p the law of the travel from one break to the next, b_0 the first breaks and m the force of one contact from a
break up to the next, the transform of F has poles where p^(s) = 1, and

    F - F_k ~ sum over pairs of roots of Re[c_n e^{s_n X}],       c_n = 2 m^(s_n) b_0^(s_n) / (transform of x p at s_n);

of contacts that form again at once, relaxed, and are equally stiff, c_n = -2 b_0^(s_n)/s_n. What is left out is an
integral along Re s = -γ, left of those roots: it is below its modulus' integral times e^{-γX}.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from master._old.cycle import Cycle
from master._old.decoherence import BROAD, crowding_rate, known_edges, survival_error, tail_edges, tail_rate
from master._old.decoherence_rest import rest_beyond
from master._old.decoherence_roots import Complex, Lines, leading_roots
from master._old.decoherence_terms import term
from master._old.decoherence_waiting import waiting_terms
from master._old.problem import Problem
from master._old.steady import steady_state
from origins import Contacts
from origins.brief import brief
from origins.contacts import LAWS, check_contacts
from origins.errors import InputError, positive, refuse, whole

Array = npt.NDArray[np.float64]

_NEAR = 0.9  # of the rate at which p^ ends: roots nearer to it are not looked for
_DEEPEST = 40.0  # per mean travel: after one of them nothing is left
_SPARE = 3
_LITTLE = 1e-2
_ACCURACY = 1e-8
_ROUND_OFF = 1e-15
_NONE = 1e-14
_HIGH = 10.0
_COUNTED = 400.0  # wait in mean travels: beyond, |p^| is nearly 1 at so many frequencies that roots are told one by one
_LONGEST = 1e12


@dataclass(frozen=True)
class DecoherenceSpectrum:
    """Leading roots of p^(s) = 1, one of each pair, slowest first; arrays of shape (n,), n = 0 where F(X) oscillates no
    further than `beyond`, as of contacts that heat breaks long before their thresholds.

    Attributes
    ----------
    roots, roots_error : complex, float array
        s_n with Im s_n > 0, per length.
    period, period_error : array
        2π/Im s_n, lengths.
    decay_length, decay_length_error : array
        -1/Re s_n, lengths.
    amplitude, amplitude_error : complex, float array
        c_n (lengths).
    kinetic_force, kinetic_force_error : float
        F_k/(N_c <k>), a length, and its error in units of the mean threshold.
    beyond : float
        Decay length of what is left out (a length): `force_error` falls with it. More roots than these may lie there.
    run_time : float
        Seconds.
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
    _left: float = field(repr=False)
    _further: tuple[Complex, Complex] = field(repr=False)
    _problem: Problem = field(repr=False)

    __repr__ = brief

    @property
    def period(self) -> Array:
        """2π/Im s_n, lengths."""
        return 2.0 * np.pi / self.roots.imag

    @property
    def period_error(self) -> Array:
        """Its error, lengths."""
        return self.period * self.roots_error / self.roots.imag

    @property
    def decay_length(self) -> Array:
        """-1/Re s_n, lengths."""
        return -1.0 / self.roots.real

    def force(self, x: npt.ArrayLike) -> Array:
        """F_k and the sum of the terms at positions X >= 0 (lengths); same shape."""
        x = np.asarray(x, dtype=float)
        terms = self.amplitude * np.exp(np.multiply.outer(x, self.roots))
        return (self.kinetic_force + terms.sum(axis=-1).real)[()]

    def force_error(self, x: npt.ArrayLike) -> Array:
        """Its error at those positions in units of the mean threshold; same shape.

        Counted are all roots left out and, as long as contacts hold since X = 0, what these still do. A bound, but for
        laws with exact values, whose jumps make the rest an estimate.
        """
        x = np.asarray(x, dtype=float)
        size = np.exp(np.multiply.outer(x, self.roots.real))
        # waves drift apart by no more than their size
        drift = np.minimum(np.multiply.outer(x, self.roots_error), 2.0)
        off = self.amplitude_error + np.abs(self.amplitude) * drift
        further, amplitudes = self._further
        rest = (np.abs(amplitudes) * np.exp(np.multiply.outer(x, further.real))).sum(axis=-1)
        with np.errstate(over="ignore", under="ignore"):
            rest = rest + (size * off).sum(axis=-1) + self._left * np.exp(-x / self.beyond) + self._standing(x)
        return (rest / self._unit + self.kinetic_force_error)[()]

    def _standing(self, x: Array) -> Array:
        """By how much F without later breaks is off the straight line that it ends in."""
        problem = self._problem
        end = np.array([problem.end])
        at = np.minimum(x.ravel() / problem.unit, problem.end)
        line = problem.known(end) + problem.known_rate(end) * (at - end)
        return (np.abs(problem.known(at) - line) * problem.unit).reshape(x.shape)


def decoherence_spectrum(contacts: Contacts, *, velocity: float = 1.0, n_roots: int = 8) -> DecoherenceSpectrum:
    """The `n_roots` slowest terms of F(X) - F_k of `contacts` on a rigid slider, at `velocity` (length per time; only
    rates, ageing and delay tell).

    Fewer where fewer there are: p^ ends at the rate at which the law's own tail falls, and where the law holds exact
    values infinitely many roots crowd about one rate.

    Raises InputError for thresholds of exact values alone, or nearly so, whose roots come as near to Re s = 0 as one
    likes; for contacts that wait for more than 1e12 times as long as they hold; for the paper's closure of ageing,
    where contacts do not break by a law of their own; and as `steady_state` does.
    """
    began = time.perf_counter()
    check_contacts(contacts, "master.decoherence_spectrum", LAWS)
    velocity, n_roots = positive("velocity", velocity), whole("n_roots", n_roots, 1)
    steady = steady_state(contacts, velocity=velocity)
    cycle = Cycle(contacts, velocity)
    wait = cycle.release.delay
    if contacts.delay is not None and wait > _LONGEST:
        refuse(
            "delay",
            contacts.delay.time,
            f"contacts wait for {wait:.3g} times as long as they hold: roots are told up to {_LONGEST:g} times; "
            "use a shorter one",
        )
    if contacts.grains is not None and float(cycle.law.atoms[1].sum()) > 1.0 - _NONE:
        refuse("velocity", velocity, "fewer than 1e-14 of new grains hold at all, without waves; slide more slowly")
    crowded = wait > _COUNTED
    problem = _problem(contacts, cycle.without_wait() if crowded else cycle)
    noise = survival_error(problem.cycle)
    law = problem.law
    if law.atomic:
        raise InputError(
            "thresholds: are exact values alone: their roots come as near to Re s = 0 as one likes and none is the "
            "slowest; give each a width, or follow F(X) with master.solve"
        )
    limit = min(_NEAR * _ends(problem), _DEEPEST)
    if limit <= 0.0:
        raise InputError("thresholds: the tail falls slower than any exponential, and with it F - F_k: no root exists")
    edges = tail_edges(law, problem.cycle, limit)
    if noise > 0.0:
        edges = known_edges(edges, problem.cycle, noise)
        # further left what is not known of the law is no longer little
        limit = min(limit, float(np.log(_LITTLE / noise)) / edges[-1])
    unit, count = problem.unit, n_roots + _SPARE
    if crowded:
        terms, gamma, left = waiting_terms(problem, edges, wait, count, limit)
        problem = problem.with_release(cycle.release)
    else:
        # waves of contacts that wait are slower
        lines = Lines(problem, edges, 2.0 * np.pi * count * _HIGH / (1.0 + wait))
        found = leading_roots(problem, edges, lines, count, limit)
        if not found.searched > 0.0 and law.edges[-1] > BROAD:
            raise InputError(
                f"thermal: contacts live for all lengths up to {law.edges[-1]:.1g} times the mean: among so many no "
                "leading oscillating wave can be resolved; master.propensity gives X*, or says that it is not known"
            )
        if not found.searched > 0.0:
            raise InputError(
                "thresholds: so much of their weight is exact, or nearly so, that no root can be told from those at "
                "Re s = 0; master.propensity gives X*, and master.solve follows F(X)"
            )
        gamma, left = rest_beyond(problem, lines, found, min(n_roots, found.roots.size), steady.force / unit)
        terms = [term(problem, edges, complex(s), noise) for s in found.roots if -s.real < gamma]
    kept, further = terms[:n_roots], terms[n_roots:]
    return DecoherenceSpectrum(
        roots=_complex([one.root for one in kept]) / unit,
        roots_error=np.array([one.root_error for one in kept]) / unit,
        amplitude=_complex([one.amplitude for one in kept]) * unit,
        amplitude_error=np.array([one.amplitude_error for one in kept]) * unit,
        decay_length_error=np.array([one.decay_error / one.root.real**2 for one in kept]) * unit,
        kinetic_force=steady.force,
        kinetic_force_error=steady.force_error,
        beyond=unit / gamma if gamma > 0.0 else np.inf,
        run_time=time.perf_counter() - began,
        _unit=contacts.mean_threshold,
        _left=left * unit,
        _further=(_complex([one.root for one in further]) / unit, _complex([one.amplitude for one in further]) * unit),
        _problem=problem,
    )


def _problem(contacts: Contacts, cycle: Cycle) -> Problem:
    """The problem up to where all first breaks are over."""
    reach = float(cycle.law.isf(_ROUND_OFF)) - min(contacts.start.span[0], 0.0)
    return Problem(contacts, reach / cycle.unit, _ACCURACY, cycle)


def _ends(problem: Problem) -> float:
    """Rate at which p^ ends, or at which exact values alone let infinitely many roots crowd."""
    law = problem.law
    return min(tail_rate(problem.cycle)[0] * law.unit, crowding_rate(law))


def _complex(values: list[complex]) -> Complex:
    return np.array(values, dtype=complex)

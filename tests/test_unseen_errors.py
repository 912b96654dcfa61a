"""Errors that the panels' own rule cannot see, planted one by one: `force_error` has to hold them.

The rule looks at polynomials and at number conservation, both of which a wrong E satisfies as well as the right one.
Each test has a control: where nobody counts what was planted, the force is further off than it claims.
"""

from __future__ import annotations

import numpy as np
import pytest
from conftest import slow
from scipy import special, stats
from solving import gauss

import master
from master.motion import Motion
from master.numerics import polynomials
from master.outcome import unheard
from master.renewal.present import BETWEEN_CHECKS
from master.rigid import march_of, motion_of, solve_rigid
from master.survival.life import ColdLife, Survivors
from master.survival.make import steady_life
from origins import (
    Ageing,
    Contacts,
    Delay,
    Drive,
    Thermal,
    gaussian,
    gaussian_start,
    rectangular,
)
from origins.start import Start
from toolkit.judge.closed_form import closed_form

LOOP = np.concatenate([np.linspace(0.0, 1.3, 27), np.linspace(1.28, -0.6, 40)])
BOX = rectangular(0.5, 1.5)


def solved(contacts, life, path=LOOP, tolerance=1e-8, time=None):
    """What `solve` does with a life of the test's own."""
    return solve_rigid(contacts, Drive(path, 1.0, time, None, "reset"), life, tolerance, unheard)


def apart(one, other):
    """Largest difference of two forces."""
    return float(np.abs(one.force - other.force).max())


class Wrong(ColdLife):
    """A life whose E is smooth, and wrong by up to a millionth; it says so, or not."""

    def __init__(self, contacts, says):
        super().__init__(contacts)
        self.error = 1e-6 if says else 0.0

    def survival_and_force(self, born, history):
        share, force, error = super().survival_and_force(born, history)
        wrong = 1.0 + 4e-6 * (1.0 - share)
        return Survivors(share * wrong, force * wrong, error)


def test_an_error_of_the_survival_is_in_the_error_of_the_force():
    contacts = Contacts(gaussian(1.0, 0.1))
    right = master.solve(contacts, LOOP, 1e-10)
    silent, honest = (solved(contacts, Wrong(contacts, says)) for says in (False, True))
    assert apart(silent, right) > 10.0 * silent.force_error
    assert apart(honest, right) <= honest.force_error
    assert not honest.success


class FixedNodes(ColdLife):
    """A life that stands for a law of stretches by a few fixed ones, and says nothing of it."""

    def __init__(self, contacts, count):
        super().__init__(contacts)
        self.nodes, self.weights = np.polynomial.legendre.leggauss(count)

    def survival_and_force(self, born, history):
        if not isinstance(born, Start) or born.is_single:
            return super().survival_and_force(born, history)
        first, last = born.span
        stretch = 0.5 * (first + last) + 0.5 * (last - first) * self.nodes
        weight = self.weights * born.pdf(stretch)
        parts = [
            super(FixedNodes, self).survival_and_force(np.array([[r]]), history) for r in stretch
        ]
        weight /= weight.sum()
        share, force = np.tensordot(weight, [(part.survival, part.force) for part in parts], 1)
        return Survivors(share, force, 0.0)


def mean_over_starts(law, start, path, cuts):
    """F from a start with a width: the mean of F from each of its stretches, at the path's end.

    Contacts do not know of each other, so that F is linear in the start; as a function of the start
    it bends at the cuts.
    """
    ends = np.unique(np.clip([*start.span, *np.linspace(*start.span, 5), *cuts], *start.span))
    stretch, weight = gauss(ends, 16)
    weight *= start.pdf(stretch)
    kept = weight > 1e-12
    forces = [master.solve(Contacts(law, r), path, 1e-9).force[-1] for r in stretch[kept]]
    return float(weight[kept] @ forces / weight[kept].sum())


@pytest.mark.slow  # quick: a start wider than steady sliding, in test_agreement.py
@pytest.mark.parametrize("turns", [False, True])
def test_a_wide_start_on_a_law_with_jumps_is_as_good_as_it_claims(turns):
    """Fixed nodes for the start see no bend of E: they are 1e-4 off with a claim of 1e-8."""
    start, path = gaussian_start(0.1, 0.08), np.array([0.0, 0.35, 0.7])
    if turns:
        path = np.array([0.0, 0.55, 0.2, -0.6])
    high, low = path.max(), path.min()
    marks = (-1.5, -1.0, -0.5, 0.5, 1.0, 1.5)
    cuts = [mark - end for mark in marks for end in (high, low)]
    cuts += [-0.5 * (high + low), -0.5 * high, -high - low, 0.0]
    exact = mean_over_starts(BOX, start, path, cuts)
    contacts = Contacts(BOX, start)
    found = master.solve(contacts, path, 1e-7)
    assert found.success and abs(found.force[-1] - exact) <= found.force_error + 1e-9
    planted = solved(contacts, FixedNodes(contacts, 16), path, 1e-7)
    assert abs(planted.force[-1] - exact) > 10.0 * planted.force_error


@pytest.mark.slow  # quick: K* of such births, within its claim (test_stick_slip.py)
def test_ageing_contacts_born_at_many_stretches_are_interpolated_to_the_error_that_is_told():
    """Between 22 stretches a polynomial would be some 5e-4 off across a narrow law of fresh thresholds."""
    ageing = Ageing(gaussian(1.0, 0.05), 0.1)
    life = steady_life(Contacts(gaussian(0.5, 0.05), ageing=ageing), 1.0)
    moves = Motion(np.array([0.0, 0.5]), np.array([0.0, 0.5]))
    lags = np.linspace(0.05, 0.4, 20)[None]
    stretch = np.linspace(0.05, 0.6, 25)[:, None]
    history = moves.history(np.broadcast_to(lags, (25, 20)), np.zeros((1, 1)))
    found = life.survival_and_force(np.broadcast_to(stretch, (25, 20)), history)
    exact = [
        life.survival_and_force(np.full((1, 1), r), moves.history(lags, np.zeros((1, 1)))).survival
        for r in stretch.ravel()[::4]
    ]
    off = np.abs(found.survival[::4] - np.concatenate(exact)).max()
    assert off <= found.error <= 1e-6


@pytest.mark.parametrize("std", [0.0004, 0.001, 0.004])
@pytest.mark.parametrize("tolerance", [0.2, slow(1e-2)])
def test_loose_tolerances_of_narrow_thresholds(std: float, tolerance: float) -> None:
    """Panels as wide as a loose tolerance allows would step over the peak of breaks, and claim a third of the error."""
    peaks = [n + std * np.linspace(-8.0, 8.0, 401) for n in (1, 2, 3, 4)]
    path = np.unique(np.concatenate([np.linspace(0.0, 5.0, 2001), *peaks]))
    contacts = Contacts(gaussian(1.0, std))
    found = master.solve(contacts, path, tolerance)
    exact, _ = closed_form(contacts, path)
    assert found.success
    assert np.abs(found.force - exact).max() < found.force_error


@pytest.mark.parametrize("power", [-0.15, -0.05, 0.3])
@pytest.mark.parametrize("tolerance", [1e-3, 1e-4])
def test_an_error_next_to_the_end_of_a_panel_is_seen(power: float, tolerance: float) -> None:
    """Where P_c, from 1/2 to 1, ends as (1 - x)^power, so do the first breaks at the end of a panel, in whose last gap
    between nodes F was off by 7.2e-4 beside a claim of 6.0e-4. Before X = 1 no contact breaks twice: F is X less the
    thresholds of those that broke."""
    last = power + 1.0
    law = stats.beta(3.0, last, loc=0.5, scale=0.5)
    place = 1.0 - np.geomspace(0.5, 1e-5, 60)
    path = 0.5 + 0.5 * place
    passed = 0.5 * 3.0 / (3.0 + last) * special.betainc(4.0, last, place)
    exact = path - (0.5 * law.cdf(path) + passed)
    contacts = Contacts(law)
    found = master.solve(contacts, path, tolerance)
    off = np.abs(found.force - exact).max() / contacts.mean_threshold
    assert 1e-6 < 2.0 * off < found.force_error < tolerance


@pytest.mark.parametrize("power", [0.5, 0.9, 1.2, 2.5])
def test_check_points_tell_of_bends_at_either_end_of_a_panel(power: float) -> None:
    """The largest residual of a polynomial through the nodes is within their factor, wherever on the panel it is."""
    place = np.linspace(0.0, 1.0, 20_001)
    for bent in (lambda at: at**power, lambda at: (1.0 - at) ** power):
        at_nodes = bent(np.append(0.0, polynomials.NODES))
        everywhere = np.abs(polynomials.values(place) @ at_nodes - bent(place)).max()
        at_checks = np.abs(polynomials.AT_CHECKS @ at_nodes - bent(polynomials.CHECKS)).max()
        assert everywhere < BETWEEN_CHECKS * at_checks


def test_points_just_before_a_panel_are_read_on_the_one_before() -> None:
    """F of narrow thresholds falls by 1e-9 within 1e-11 of the way."""
    contacts = Contacts(gaussian(1.0, 0.003))
    rough = np.linspace(0.0, 6.0, 61)
    motion, _ = motion_of(Drive(rough), contacts.mean_threshold, True)
    panels = march_of(contacts, motion, ColdLife(contacts), 1e-10).run().solved.begin[1:]
    path = np.sort(np.concatenate([rough, panels * (1.0 - 8e-13)]))
    found = master.solve(contacts, path, 1e-10)
    exact, rounded = closed_form(contacts, path)
    assert np.abs(found.force - exact).max() < found.force_error + rounded


def test_a_residual_of_many_contacts_is_no_estimate() -> None:
    """Contacts of a start that one in 1e23 survives: 1.7 mean thresholds were told where 2.0 were true."""
    ageing = Ageing(gaussian(1.0, 0.02), 5e-4)
    contacts = Contacts(gaussian(0.5, 0.05), gaussian_start(1.0, 0.025), ageing=ageing)
    found = master.solve(contacts, np.linspace(0.0, 3.0, 24), 1e-6)
    assert not found.success and found.force_error == np.inf
    assert "nothing is known of the force" in found.message


def test_contacts_of_legs_that_are_left_out_are_counted() -> None:
    """On each leg 3e-9 are born, so few that it is left out, though they hold: twenty legs miss twenty times as many.

    None breaks a second time, so that B = P(x_s < X) up to the turn, and with it F is known."""
    law, delay, top = gaussian(1.0, 0.1), 0.6, 0.7
    broken = law.ppf(
        3e-9 * np.arange(1, 21)
    )  # where as many have broken on each leg as on the one before
    times = np.array([0.0, top, *(broken + delay), 1.6])
    speeds = np.append(1.0, np.resize([-0.5, -0.4], times.size - 2))
    path = np.append(0.0, np.cumsum(speeds * np.diff(times)))
    found = master.solve(Contacts(law, delay=Delay(delay)), path, 1e-3, time=times)
    s, weight = gauss(np.clip([0.0, *(times[1:] - delay), top], 0.0, top))
    held = (weight * law.pdf(s))[:, None] * (s[:, None] + delay < times)
    stretch = path - np.interp(s + delay, times, path)[:, None]
    exact = path * law.sf(np.maximum.accumulate(path)) + (held * stretch).sum(axis=0)
    off = np.abs(found.force - exact).max()
    assert 1e-9 < off <= found.force_error < 10.0 * off


def test_what_a_march_has_missed_is_counted_by_one_that_goes_on_from_a_cut() -> None:
    """Sums over births of the leg before, asked for to 1e-5 only, miss more than survivals do."""
    contacts = Contacts(gaussian(1.0, 0.2))
    motion = Motion.along(np.array([0.0, 1.5, 0.3, 1.0]))
    march = march_of(contacts, motion, ColdLife(contacts), 1e-2)
    march.births.accuracy = 1e-5
    march.run()
    assert march.unseen_error > 2.0 * march.survival_error
    assert march.cut(march.solved.end, march.births).unseen_error == march.unseen_error


@pytest.mark.parametrize(
    ("half_width", "frequency", "top", "end", "tolerance"),
    [
        (0.428871, 0.1487, 3.1362, -0.234, 1e-2),
        (0.4247640234630534, 0.06422209070664195, 2.122098355052337, -0.5968, 1e-4),
    ],
)
def test_breaks_bend_where_contacts_at_a_bend_of_the_law_come_back_after_a_turn(
    half_width, frequency, top, end, tolerance
):
    """In heat such contacts break a little everywhere, and panels over the bend claimed 3.1e-4 for an error of 5.3e-4;
    five nodes on the births before the turn claimed 1.6e-6 for 2.4e-6."""
    heat = Thermal("soft", temperature=0.14, attempt_frequency=frequency)
    contacts = Contacts(rectangular(1.0 - half_width, 1.0 + half_width), thermal=heat)
    path = np.concatenate([np.linspace(0.0, top, 300), np.linspace(top, end, 500)[1:]])
    fine, coarse = (master.solve(contacts, path, each) for each in (1e-9, tolerance))
    assert coarse.success and apart(coarse, fine) <= coarse.force_error + fine.force_error

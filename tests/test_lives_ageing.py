"""What is left of contacts whose thresholds age: closed forms, and one road against the other."""

import numpy as np
import pytest
from scipy.special import log_ndtr, ndtr

import origins
from master.lives.age.ageing import AgeingLife
from master.lives.age.passage import Passage
from master.motion.motion import Motion
from origins import Ageing, Contacts, InputError, Thermal, gaussian_start
from origins.start import SingleStart

FRESH, FINAL = origins.gaussian(0.5, 0.1), origins.gaussian(1.0, 0.01)
# of Fig. A05's parameters, by v/D
KINETIC_FORCE = {1000.0: 0.499543, 100.0: 0.496482, 10.0: 0.490625, 3.0: 0.487908}


def inverse_gaussian(t, distance, diffusion, speed):
    """Share of thresholds, at `distance` at first, that no level which moves up has met."""
    spread = np.sqrt(2.0 * diffusion * t)
    first = ndtr((distance - speed * t) / spread)
    rest = speed * distance / diffusion + log_ndtr(-(distance + speed * t) / spread)
    return first - np.exp(rest)


def integrals(survival, reach):
    """Integrals of E and of t E over 0 < t < reach."""
    x, w = np.polynomial.legendre.leggauss(16)
    edges = np.linspace(0.0, reach, 301)
    half = 0.5 * np.diff(edges)[:, None]
    t = edges[:-1, None] + half * (x + 1.0)
    held = half * w * survival(t)
    return held.sum(), (held * t).sum()


@pytest.mark.parametrize("diffusion", [1e-3, 0.1])
@pytest.mark.parametrize("speed", [1.0, 0.25])
def test_first_passage_without_drift_is_inverse_gaussian(diffusion, speed):
    """A final law so wide that it does not pull."""
    passage = Passage(origins.identical(0.7), Ageing(origins.gaussian(1.0, 1e9), diffusion), speed)
    t = np.linspace(0.05, 2.0, 60) / speed
    exact = inverse_gaussian(t, 0.7, diffusion, speed)
    assert np.abs(passage.survival(t) - exact).max() < 2e-12


@pytest.mark.parametrize("speed", KINETIC_FORCE)
def test_kinetic_force_of_figure_a05(speed):
    passage = Passage(FRESH, Ageing(FINAL, 1.0), speed)
    whole, moment = integrals(passage.survival, passage.reach_lag)
    assert speed * moment / whole == pytest.approx(KINETIC_FORCE[speed], abs=5.1e-7)
    assert passage.error < 1e-12
    ends = passage.survival(np.array([0.0, passage.reach_lag]))
    assert ends[0] == pytest.approx(1.0, abs=1e-15) and ends[1] < 1e-13


@pytest.mark.parametrize("start", [0.15, -0.2])
def test_passage_of_contacts_that_start_stretched(start):
    """Where nothing ages the survival is S(|x|)/S(|start|) of the fresh law, up and down."""
    passage = Passage(FRESH, Ageing(FINAL, 1e-22), 2.0, start)
    t = np.linspace(0.0, 0.6, 121)
    furthest = np.maximum(np.abs(start + 2.0 * t), abs(start))
    assert np.abs(passage.survival(t) - FRESH.sf(furthest) / FRESH.sf(abs(start))).max() < 1e-12


def test_refusals_of_a_passage():
    with pytest.raises(InputError, match=r"start = 50.0: lies beyond every threshold"):
        Passage(FRESH, Ageing(FINAL, 1.0), 1.0, 50.0)


YOUNG, OLD = origins.gaussian(0.5, 0.15), origins.gaussian(0.9, 0.08)


def forward(length, speed=1.0):
    return Motion(np.array([0.0, length / abs(speed)]), np.array([0.0, np.sign(speed) * length]))


@pytest.mark.parametrize("start", [0.15, -0.2])
@pytest.mark.parametrize("diffusion", [1e-4, 0.1])
def test_strands_follow_the_integral_equation(diffusion, start):
    contacts = Contacts(YOUNG, start, ageing=Ageing(OLD, diffusion))
    life = AgeingLife(contacts, forward(1.4), 1e-5)
    passage = Passage(YOUNG, contacts.ageing, 1.0, start)
    strand, differences = life.begin(contacts.start), []
    for k in range(1, 15):
        strand.advance(1.0, 0.1)
        share, force = strand.left()[:, 0]
        differences.append(share - passage.survival(np.array(0.1 * k)))
        assert force == pytest.approx(share * (start + 0.1 * k), rel=1e-12)
    assert np.abs(differences).max() < life.error < 1.1e-5


def test_errors_of_strands_fall_by_more_than_four_with_each_resolution():
    contacts = Contacts(YOUNG, ageing=Ageing(OLD, 1e-2))
    passage = Passage(YOUNG, contacts.ageing, 1.0)
    errors = []
    for accuracy in (1e-4, 1e-6):
        life = AgeingLife(contacts, forward(1.4), accuracy)
        strand, worst = life.begin(SingleStart(0.0)), 0.0
        for k in range(1, 15):
            strand.advance(1.0, 0.1)
            worst = max(worst, abs(strand.left()[0, 0] - passage.survival(np.array(0.1 * k))))
        errors.append((life.mesh.resolution, worst))
    (first, coarse), *_, (last, fine) = errors
    assert last > first and fine < coarse * 0.25 ** (last - first)


@pytest.mark.parametrize("start", [0.45, -0.45])
def test_hold_at_the_mean_of_the_final_law(start):
    """There the drift does not push: by reflection E = 2 Φ(z) - 1, averaged over the fresh."""
    std, diffusion = 0.08, 5e-3
    contacts = Contacts(YOUNG, start, ageing=Ageing(origins.gaussian(0.45, std), diffusion))
    life = AgeingLife(contacts, Motion(np.array([0.0, 4.0]), np.zeros(2)), 1e-5)
    fresh = np.linspace(0.45, 1.8, 20_001)
    weight = YOUNG.pdf(fresh) / np.trapezoid(YOUNG.pdf(fresh), fresh)
    strand, clock = life.begin(contacts.start), 0.0
    for duration in (0.01, 0.1, 0.3, 1.0, 2.5):
        strand.advance(0.0, duration)
        clock += duration
        decay = np.exp(-diffusion / std**2 * clock)
        z = (fresh - 0.45) * decay / (std * np.sqrt(1.0 - decay**2))
        exact = np.trapezoid(weight * (2.0 * ndtr(z) - 1.0), fresh)
        assert abs(strand.left()[0, 0] - exact) < life.error < 1e-5


def test_strands_that_hardly_age_hold_as_far_as_they_have_been():
    """At rest E = S(m)/S(|r|), m the largest |x|, on a path that turns and passes 0."""
    contacts = Contacts(YOUNG, 0.1, ageing=Ageing(OLD, 1e-8))
    motion = Motion(np.array([0.0, 0.4, 1.6, 2.0]), np.array([0.0, 0.4, -0.8, -0.4]))
    life = AgeingLife(contacts, motion, 1e-3)
    strand = life.begin(contacts.start)
    for speed, duration, furthest in ((1.0, 0.4, 0.5), (-1.0, 1.2, 0.7), (1.0, 0.4, 0.7)):
        strand.advance(speed, duration)
        assert strand.left()[0, 0] == pytest.approx(YOUNG.sf(furthest) / YOUNG.sf(0.1), abs=1e-4)


@pytest.mark.parametrize("law", ["soft", "stiff"])
def test_heat_without_ageing_by_quadrature(law):
    thermal = Thermal(law, 0.05, 0.3)
    contacts = Contacts(YOUNG, thermal=thermal, ageing=Ageing(OLD, 1e-9))
    strand = AgeingLife(contacts, forward(0.6), 1e-4).begin(SingleStart(0.0))
    strand.advance(1.0, 0.6)
    x, w = np.polynomial.legendre.leggauss(400)
    threshold = 1.1 + 0.5 * x
    spent = thermal.cumulative(0.6, threshold)
    exact = 0.5 * w @ (YOUNG.pdf(threshold) * np.exp(-spent))
    assert strand.left()[0, 0] == pytest.approx(exact, abs=2e-5)


def test_thresholds_between_walls():
    """Uniform by the time they are met, they all come down within L²/(3 D) of the wall."""
    fresh, diffusion = origins.rectangular(0.6, 1.0), 1e3
    contacts = Contacts(fresh, -0.4, ageing=Ageing(origins.rectangular(0.5, 1.5), diffusion))
    life = AgeingLife(contacts, forward(2.0), 1e-3)
    motion = forward(1.0)
    lag = np.append(np.linspace(0.0, 0.5, 50), 0.5 + 0.01 * np.linspace(0.0, 1.0, 10_001)[1:] ** 2)[
        None
    ]
    share = life.left(SingleStart(0.0), motion.history(np.ones((1, 1)), 1.0 - lag))[0, 0]
    assert share[lag[0] <= 0.5].min() > 1.0 - 1e-9
    late = np.trapezoid(share, lag[0]) - 0.5
    assert late == pytest.approx(1.0 / (3.0 * diffusion), rel=2.0 / diffusion)


@pytest.mark.parametrize("speed", [2.0, -2.0])
def test_forward_life_of_a_spread_start(speed):
    """Against one passage for each of many stretches; strands agree where the law is Gaussian."""
    start = gaussian_start(0.1, 0.03)
    contacts = Contacts(YOUNG, start, ageing=Ageing(OLD, 1e-2))
    t = np.linspace(0.02, 0.6, 9)[:, None]
    x, w = np.polynomial.legendre.leggauss(24)
    stretch = 0.1 + 0.2 * x
    weight = 0.2 * w * start.pdf(stretch)
    sign = np.sign(speed)
    held = [Passage(YOUNG, contacts.ageing, 2.0, y * sign).survival(t[:, 0]) for y in stretch]
    exact = weight @ held, weight @ (held * (stretch[:, None] + speed * t[:, 0]))
    history = forward(1.2, speed).history(t, np.zeros((1, 1)))
    life = AgeingLife(contacts, forward(1.2, speed), 1e-6)
    found = life.left(start, history)[:, :, 0]
    assert np.abs(found - exact).max() < 1e-6
    passage = life.left(SingleStart(0.1), history)[:, :, 0]
    contacts.ageing.normal = None
    strands = AgeingLife(contacts, forward(1.2, speed), 1e-4)
    born = strands.left(SingleStart(0.1), history)[:, :, 0]
    assert np.abs(born - passage).max() < 1e-4


def test_refusal_of_exact_values_among_strands():
    contacts = Contacts(origins.identical(0.5), ageing=Ageing(OLD, 1e-2))
    with pytest.raises(InputError, match=r"thresholds: hold the single value 0.5: .* give it a"):
        AgeingLife(contacts, Motion(np.arange(3.0), np.array([0.0, 1.0, 0.0])))

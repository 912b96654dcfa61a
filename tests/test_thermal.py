"""The rate of thermal breaking, its integral and the inverse, against mpmath from 1e-6 to 1e3 in temperature."""

import mpmath
import numpy as np
import pytest

import origins
from origins import Contacts, InputError, Thermal
from origins.laws.dawson import inverse_log_growth, log_growth

mpmath.mp.dps = 50
LAWS = ["soft", "stiff"]
POINTS = 600


def exact_rate(thermal: Thermal, x, threshold, stiffness=1.0):
    """h(x; x_s) as the paper writes it, with k_i/k_BT = stiffness/T."""
    x, threshold, energy = (
        abs(mpmath.mpf(x)),
        mpmath.mpf(threshold),
        mpmath.mpf(stiffness) / thermal.temperature,
    )
    if thermal.law == "soft":
        return thermal.attempt_frequency * mpmath.exp(-energy * (threshold**2 - x**2) / 2)
    s = 1 - x / threshold
    return (
        thermal.attempt_frequency
        * mpmath.sqrt(s)
        * mpmath.exp(-energy * threshold**2 * s ** mpmath.mpf(1.5) / 2)
    )


def exact_cumulative(thermal: Thermal, x, threshold, start=0.0, stiffness=1.0):
    """|integral of h from start to x| from its antiderivatives, an error function and an exponential."""
    threshold, energy = mpmath.mpf(threshold), mpmath.mpf(stiffness) / thermal.temperature

    def from_zero(y):
        y = mpmath.mpf(y)
        if thermal.law == "soft":
            a = mpmath.sqrt(energy / 2)
            return (
                mpmath.sqrt(mpmath.pi)
                / (2 * a)
                * mpmath.erfi(a * y)
                * mpmath.exp(-((a * threshold) ** 2))
            )
        c, s = energy * threshold**2 / 2, 1 - abs(y) / threshold
        fall = mpmath.exp(-c * s ** mpmath.mpf(1.5)) - mpmath.exp(-c)
        return mpmath.sign(y) * 2 * threshold / (3 * c) * fall

    return thermal.attempt_frequency * abs(from_zero(x) - from_zero(start))


def cases(law: str):
    """Temperatures 1e-6 to 1e3, ω 1e-12 to 1e12; stretches from next to zero to the threshold itself, also behind
    x = 0; starts at 0, anywhere, and just below x."""
    random = np.random.default_rng(7 if law == "soft" else 8)
    for i in range(POINTS):
        thermal = Thermal(law, 10.0 ** random.uniform(-6, 3), 10.0 ** random.uniform(-12, 12))
        threshold = 10.0 ** random.uniform(-1.0, 0.7)
        near_end = 1.0 - 10.0 ** random.uniform(-15, -1)
        x = threshold * random.choice([1e-12, 1e-3, random.uniform(-1, 1), near_end, 1.0])
        start = (
            0.0,
            threshold * random.uniform(-1, 1),
            x * (1.0 - 10.0 ** random.uniform(-12, -1)),
        )[i % 3]
        yield thermal, float(x), float(threshold), float(start), 10.0 ** random.uniform(-1, 1)


@pytest.mark.parametrize("law", LAWS)
def test_rate_and_cumulative_rate(law: str) -> None:
    underflown = 0
    for thermal, x, threshold, start, stiffness in cases(law):
        pairs = [
            (thermal.rate, thermal.log_rate, exact_rate, (x, threshold, stiffness)),
            (
                thermal.cumulative,
                thermal.log_cumulative,
                exact_cumulative,
                (x, threshold, start, stiffness),
            ),
        ]
        for plain, logarithm, exact, arguments in pairs:
            known = exact(thermal, *arguments)
            if known == 0:  # a stiff contact at its threshold, or x = start
                assert plain(*arguments) == 0.0 and logarithm(*arguments) == -np.inf
                continue
            told = float(logarithm(*arguments))
            assert np.isfinite(told) and abs(told - mpmath.log(known)) <= 1e-13 * max(
                1.0, abs(told)
            )
            underflown += known < 1e-308
            if known > 1e-300:
                assert abs(float(plain(*arguments)) / known - 1) < 1e-12, (thermal, arguments)
    assert underflown > 50


@pytest.mark.parametrize("law", LAWS)
def test_inverse(law: str) -> None:
    """Right in x, or in the amount that leads there: where the rate vanishes, or rises steeply, one must give."""
    reached = 0
    for thermal, x, threshold, start, stiffness in cases(law):
        start, x = sorted((start, x))
        amount = float(exact_cumulative(thermal, x, threshold, start, stiffness))
        if not amount > 1e-300:
            continue
        found = float(thermal.inverse(amount, threshold, start, stiffness))
        assert start <= found <= threshold
        back = exact_cumulative(thermal, found, threshold, start, stiffness)
        off = min(abs(found - x) / threshold, abs(back / amount - 1))
        assert off < 1e-12, (thermal, x, threshold, start)
        reached += 1
        # the mirror image: backward from -start to -x
        behind = thermal.cumulative(-x, threshold, -start, stiffness)
        assert behind == thermal.cumulative(x, threshold, start, stiffness)
    assert reached > 100


@pytest.mark.parametrize("law", LAWS)
def test_closed_forms_are_the_integral(law: str) -> None:
    for temperature, x, start in [
        (1e-3, 0.99, 0.9),
        (0.1, 0.9, -0.8),
        (1e3, 1, -1),
        (0.02, -0.3, -1),
    ]:
        thermal = Thermal(law, temperature, 3.0)
        corners = sorted({start, x} | ({0.0} if start < 0.0 < x else set()))
        integral = mpmath.quad(lambda y, law=thermal: exact_rate(law, y, 1.0, 0.7), corners)
        assert abs(thermal.cumulative(x, 1.0, start, 0.7) / integral - 1) < 1e-12


@pytest.mark.parametrize("law", LAWS)
def test_ends_of_the_inverse(law: str) -> None:
    thermal = Thermal(law, 0.05, 2.0)
    whole = float(thermal.cumulative(1.0, 1.0, -0.9))
    amounts = np.array([0.0, whole * (1 - 1e-9), whole * (1 + 1e-9), 1e300, np.inf])
    found = thermal.inverse(amounts, 1.0, -0.9)
    assert found[0] == -0.9 and 0.99 < found[1] < 1.0 and (found[2:] == 1.0).all()
    assert (thermal.inverse(amounts, 1.0, 1.0) == 1.0).all()
    # from -0.9 on the first stretch is the steep one; amounts that end on both sides of x = 0
    found = thermal.inverse(whole * np.linspace(0.0, 1.0, 101), 1.0, -0.9)
    assert (np.diff(found) > 0.0).all() and found[10] < -0.5 and found[-2] > 0.5


def test_dawson_logarithm_and_its_inverse() -> None:
    y = np.concatenate(
        [np.geomspace(1e-300, 1e-3, 40), np.linspace(0.01, 30.0, 80), np.geomspace(30.0, 2e3, 20)]
    )
    for value, told in zip(y, log_growth(y), strict=True):
        known = mpmath.log(mpmath.sqrt(mpmath.pi) / 2 * mpmath.erfi(value))
        assert abs(told - known) < 1e-14 * max(1, abs(known))
    np.testing.assert_allclose(inverse_log_growth(log_growth(y)), y, rtol=2e-13)
    # far beyond where exp(y²) or D(y) can be written: y² - ln 2y = level
    far = inverse_log_growth(np.array([1e12, 1e300]))
    np.testing.assert_allclose(far**2 - np.log(2.0 * far), [1e12, 1e300], rtol=1e-15)
    assert inverse_log_growth(np.array([-np.inf, np.inf, -800.0])).tolist() == [0.0, np.inf, 0.0]


@pytest.mark.parametrize(("law", "power"), [("soft", 2.0), ("stiff", 5.0 / 3.0)])
def test_force_lost_at_high_speed(law: str, power: float) -> None:
    """To first order in ω/v, F_k - F(∞) = -(ω/v) ∫(x - 1/2) A dx for identical thresholds 1: -T²/2 for soft contacts,
    as T^(5/3) for stiff ones (Garg's exponents, 3/2 and 1/2)."""
    temperatures = np.array([1e-5, 1e-4])
    nodes, weights = np.polynomial.legendre.leggauss(200)
    # the boundary layer below the threshold, in which A falls to nothing
    reach = 40.0 * (temperatures if law == "soft" else temperatures ** (2.0 / 3.0))
    x = 1.0 - reach[:, None] * 0.5 * (nodes + 1.0)
    lost = [
        float((0.5 * width * weights * (at - 0.5) * Thermal(law, t).cumulative(at, 1.0)).sum())
        for width, at, t in zip(reach, x, temperatures, strict=True)
    ]
    assert np.log(lost[1] / lost[0]) / np.log(10.0) == pytest.approx(power, abs=0.01)
    if law == "soft":
        assert lost[0] == pytest.approx(0.5 * temperatures[0] ** 2, rel=1e-4)


@pytest.mark.parametrize("law", LAWS)
def test_linked_stiffness_in_the_barrier(law: str) -> None:
    """T is k_BT/<k>; each contact's own is k_BT/k_i with k_i = <k> x_si/<x_s>, so the barrier grows as x_s³."""
    thermal, thresholds = Thermal(law, 0.24, 2.0), np.array([0.3, 1.0, 4.0])
    linked = Contacts(origins.gw_plastic(0.2), thermal=thermal, stiffness="linked")
    stiffness = linked.relative_stiffness(thresholds)
    np.testing.assert_allclose(stiffness, thresholds / linked.thresholds.mean(), rtol=1e-15)
    told = thermal.log_cumulative(0.6 * thresholds, thresholds, 0.1, stiffness)
    for value, share, threshold in zip(told, stiffness, thresholds, strict=True):
        own = Thermal(law, 0.24 / float(share), 2.0).log_cumulative(0.6 * threshold, threshold, 0.1)
        assert value == pytest.approx(float(own), rel=1e-13)
    relaxed = thermal.log_rate(0.0, thresholds, stiffness) - np.log(2.0)
    np.testing.assert_allclose(relaxed / relaxed[1], thresholds**3, rtol=1e-13)
    assert Contacts(origins.gw_plastic(0.2)).relative_stiffness(thresholds).tolist() == [1.0] * 3


@pytest.mark.parametrize("scale", [1e-9, 1e9])
@pytest.mark.parametrize("law", LAWS)
def test_unit_of_length_does_not_matter(law: str, scale: float) -> None:
    x, threshold = np.array([-0.4, 0.2, 0.9]), np.array([1.0, 1.5, 0.95])
    plain, scaled = Thermal(law, 0.03), Thermal(law, 0.03 * scale**2)
    rates = scaled.rate(x * scale, threshold * scale)
    np.testing.assert_allclose(rates, plain.rate(x, threshold), rtol=1e-13)
    amount = plain.cumulative(0.5, 1.0, x[:1])
    end = scaled.inverse(amount * scale, scale, x[:1] * scale)
    np.testing.assert_allclose(end, [0.5 * scale], rtol=1e-12)


SOFT, STIFF = Thermal("soft", 0.1), Thermal("stiff", 0.1)


@pytest.mark.parametrize(
    ("call", "begins"),
    [
        (lambda: Thermal("weak", 0.1), "law = 'weak': "),
        (lambda: Thermal("soft", 0.0), "temperature = 0.0: must be above zero"),
        (lambda: Thermal("soft", 0.1, -1.0), "attempt_frequency = -1.0: "),
        (lambda: Thermal("soft", 0.1, closure="mean"), "closure = 'mean': "),
        (lambda: SOFT.rate([0.5, 1.1], 1.0), "x = 1.1: a contact holds only where |x| is at most"),
        (lambda: SOFT.rate(0.5, 0.0), "threshold = 0.0: "),
        (
            lambda: STIFF.cumulative(0.5, 1.0, start=-1.2),
            "start = -1.2: a contact holds only where",
        ),
        (lambda: STIFF.inverse([1.0, -2.0], 1.0), "amount = -2.0: must be zero or above"),
        (lambda: SOFT.rate([0.1, 0.2, 0.3], [1.0, 1.1]), "x, threshold, stiffness: must be num"),
    ],
)
def test_refusals(call, begins: str) -> None:
    with pytest.raises(InputError) as refusal:
        call()
    assert str(refusal.value).startswith(begins) and "\n" not in str(refusal.value)

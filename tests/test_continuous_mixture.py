"""Laws averaged over a parameter, such as the orientation of grains."""

import numpy as np
import pytest
from grain_references import exact_hazard, integral
from references import mp
from scipy import stats

import master
import origins
from origins import InputError, grains


def test_all_orientations() -> None:
    """Against mpmath's integral over phi, to the accuracy asked."""
    rho = 1.5

    def strength(phi: float) -> float:
        return 1.0 + 6.0 * np.exp(-((phi / 0.3) ** 2))

    def often(phi: float) -> float:
        return 1.0 + np.cos(4.0 * phi)

    law = origins.continuous_mixture(
        lambda phi: grains(rho, B=1.0 / strength(phi)),
        0.0,
        np.pi / 4.0,
        density=often,
        accuracy=1e-8,
    )
    assert law.quadrature_error <= 1e-8 and law.weights.size <= 128
    assert law.weights.sum() == pytest.approx(1.0, abs=1e-14) and law.onset_power == 1.0
    with mp.workdps(20):
        whole = mp.quad(lambda phi: 1 + mp.cos(4 * phi), [0, mp.pi / 4])
        for x in (0.2, 1.0, 2.0, 3.0, 4.5):

            def held(phi: mp.mpf, x: float = x) -> mp.mpf:
                B = 1 / (1 + 6 * mp.exp(-((phi / mp.mpf("0.3")) ** 2)))
                alive = 1 + B * mp.mpf(x) ** 2 < (mp.mpf(3) / 2 * rho) ** 2
                return (
                    (1 + mp.cos(4 * phi)) * mp.exp(-exact_hazard(mp.mpf(x), rho, B))
                    if alive
                    else mp.mpf(0)
                )

            assert (
                abs(law.sf(x) - float(integral(held, mp.linspace(0, mp.pi / 4, 33)) / whole)) < 2e-8
            )
    solved = master.solve(
        origins.Contacts(law), np.linspace(0.0, 5.0 * law.mean(), 101), tolerance=1e-8
    )
    assert solved.success and solved.force_error <= 1e-8


def test_equal_orientations_of_a_closed_form() -> None:
    """Rayleigh laws of equal rates: S(x) = (e^(-a x²) - e^(-b x²))/((b - a) x²)."""
    law = origins.continuous_mixture(origins.gw_plastic, 1.0, 3.0)
    x = np.linspace(0.05, 4.0, 50)
    exact = (np.exp(-x * x) - np.exp(-3.0 * x * x)) / (2.0 * x * x)
    assert np.abs(law.sf(x) - exact).max() < 1e-10
    assert law.mean() == pytest.approx(np.sqrt(np.pi) / 2.0 * (np.sqrt(3.0) - 1.0), rel=1e-10)
    frozen = origins.continuous_mixture(lambda rate: stats.expon(scale=1.0 / rate), 1.0, 2.0)
    assert frozen.sf(1.0) == pytest.approx(np.exp(-1.0) - np.exp(-2.0), abs=1e-10)


MOVING = [
    lambda phi: origins.identical(1.0 + phi),
    lambda phi: origins.rectangular(1.0, 2.0 + phi),
    lambda phi: stats.expon(loc=phi),
    lambda phi: stats.beta(0.5, 2.0, loc=1.0 + phi),
    lambda phi: origins.gw_gaussian(0.0, 1.0 + phi, regime="mixed", plasticity_index=5.0),
]


def test_jumps_that_stand_still_are_kept() -> None:
    fixed = [origins.rectangular(1.0, 2.0), origins.identical(0.5)]
    law = origins.continuous_mixture(
        lambda phi: origins.mixture([*fixed, grains(phi, B=1.0)], [0.4, 0.2, 0.4]),
        1.5,
        2.5,
        accuracy=1e-6,
    )
    assert law.atoms[1].sum() == pytest.approx(0.2)
    assert float(law.pdf(1.0 - 1e-9)) < float(law.pdf(1.0 + 1e-9)) - 0.39


MOVES = "law: an exact value or a jump of the density moves with phi, "


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ({"upper": 0.0}, "upper = 0.0: must be above lower = 0"),
        ({"law": 3.0}, "law = 3.0: must be a function of phi"),
        ({"density": lambda phi: -1.0}, "density = -1.0: must not be below zero, as at phi = "),
        ({"density": lambda phi: 0.0}, "density = <function"),
        ({"accuracy": 0.0}, "accuracy = 0.0: must be above zero"),
        *(({"law": law}, MOVES) for law in MOVING),
        ({"law": lambda phi: stats.beta(2.0, 2.0, loc=phi)}, "accuracy = 1e-10: 512 laws reach"),
        ({"law": lambda phi: phi}, "thresholds = "),
    ],
)
def test_refused_mixtures(arguments: dict, says: str) -> None:
    given = {"law": lambda phi: grains(1.0 + phi, B=1.0), "lower": 0.0, "upper": 1.0} | arguments
    with pytest.raises(InputError) as caught:
        origins.continuous_mixture(**given)
    assert str(caught.value).startswith(says) and "\n" not in str(caught.value)

"""The kinetic force along speeds as a polynomial: its claim of its error beside the forces themselves."""

import numpy as np
import pytest
from conftest import slow
from scipy import stats

import origins
from master.steady import kinetic_table
from master.steady.kinetic import kinetic_curve
from master.steady.kinetic_table import tabulated
from origins import Contacts, Thermal

# Drawn tables of each law of heat, and speeds within each at which forces are solved one by one.
DRAWN, SPEEDS = 8, 100


def drawn_contacts(draw: np.random.Generator, law: str) -> Contacts:
    """Thresholds of a drawn family about the mean 1, which heat of this law breaks."""
    shape = draw.uniform(1.5, 20.0)
    families = [
        origins.gaussian(1.0, draw.uniform(0.05, 0.4)),
        stats.gamma(shape, scale=1.0 / shape),
        stats.weibull_min(draw.uniform(1.2, 5.0)),
        stats.lognorm(draw.uniform(0.1, 0.6)),
    ]
    much = 10.0 ** draw.uniform(-2.0, -0.7)
    heat = Thermal(law, width=much) if law == "eyring" else Thermal(law, much)
    return Contacts(families[draw.integers(len(families))], thermal=heat)


@pytest.mark.parametrize("law", ["eyring", slow("soft"), slow("stiff")])
def test_the_table_is_off_by_no_more_than_it_claims(law: str) -> None:
    """Of drawn contacts, along 3 to 12 decades; and each table is told, with an error of 1e-3 to 1e-5."""
    draw = np.random.default_rng(["eyring", "soft", "stiff"].index(law))
    for _ in range(DRAWN):
        contacts, asked = drawn_contacts(draw, law), 10.0 ** draw.uniform(-5.0, -3.0)
        middle, half = draw.uniform(-7.0, 0.0), draw.uniform(1.5, 6.0)
        ends = np.log(10.0) * np.array([middle - half, middle + half])
        table = tabulated(contacts, ends, asked)
        assert table is not None and table.error <= asked
        log_speeds = np.linspace(*ends, SPEEDS)
        off = np.abs(table.force(log_speeds) - kinetic_curve(contacts, np.exp(log_speeds)).force)
        assert off.max() <= table.error


def test_a_force_with_a_sharp_bend_has_no_table() -> None:
    """Contacts of nearly one threshold: F_k rises with ln V, and no more where heat does not break them in time."""
    contacts = Contacts(origins.gaussian(1.0, 1e-3), thermal=Thermal("eyring", width=1e-3))
    assert tabulated(contacts, np.log([1e-60, 1e60]), 1e-7) is None


def test_there_is_none_at_speeds_of_a_slider_that_moves_on_in_the_last_digit_of_the_time() -> None:
    """A step of no time told 1e292, which a verdict on samples in heat was refused for, in units that nobody gave."""
    warm = origins.Contacts(origins.gaussian(1.0, 0.2), thermal=origins.Thermal("soft", 0.05, 0.1))
    assert tabulated(warm, np.log([0.1, 1.0]), 1e-3) is not None
    for ends in ([1.0, 1e292], [1e-292, 1.0]):
        assert tabulated(warm, np.log(ends), 1e-3) is None


def test_a_force_that_no_speed_between_the_ends_has_asks_for_two_speeds_alone(monkeypatch) -> None:
    """A slider that slips asked for whole tables at each look, of contacts that grow in heat for a minute."""
    asked = list[int]()

    def counted(contacts, speeds):
        asked.append(speeds.size)
        return kinetic_curve(contacts, speeds)

    monkeypatch.setattr(kinetic_table, "kinetic_curve", counted)
    warm = Contacts(origins.gaussian(1.0, 0.2), thermal=Thermal("soft", 0.05, 0.1))
    ends = np.log([1e-4, 1.0])
    low, high = kinetic_curve(warm, np.exp(ends)).force
    for held in (low - 1e-3, high + 1e-3):
        assert tabulated(warm, ends, 1e-4, held=held) is None
    assert asked == [2, 2]
    table = tabulated(warm, ends, 1e-4, held=0.5 * (low + high))
    assert table is not None and np.isfinite(table.log_speed(0.5 * (low + high)))

"""Paths in time against what is known exactly: single contacts followed one by one, sums over thresholds, cohorts."""


import numpy as np
import pytest

import master
from origins import Contacts, Delay, Thermal, gaussian, identical, mixture

PATH = np.array([0.0, 0.5, 1.3, 2.1, 2.1, 2.1, 2.6, 3.3, 2.5, 1.0])
TIME = np.array([0.0, 0.5, 1.3, 2.1, 3.0, 50.0, 50.5, 51.2, 52.0, 53.5])


def lumps(values: list[float], weights: list[float], start: float, delay: float) -> tuple[np.ndarray, np.ndarray]:
    """Force and holding along PATH of contacts with so many exact thresholds, each followed from birth to break."""
    force, holding = np.zeros(PATH.size), np.zeros(PATH.size)
    pending = [(0.0, -start, 1.0)]  # since when, X less the stretch, share
    while pending:
        since, place, share = pending.pop()
        for value, weight in zip(values, weights, strict=True):
            broken = np.inf
            for k in range(PATH.size - 1):
                begin = max(since, TIME[k])
                if begin >= TIME[k + 1] or PATH[k + 1] == PATH[k]:
                    continue
                speed = (PATH[k + 1] - PATH[k]) / (TIME[k + 1] - TIME[k])
                last = PATH[k + 1] - place
                if abs(last) >= value:
                    broken = TIME[k + 1] - (abs(last) - value) / abs(speed)
                    break
            held = (since <= TIME) & (broken > TIME)
            force += share * weight * held * (PATH - place)
            holding += share * weight * held
            born = broken + delay
            if born < TIME[-1]:
                pending.append((born, float(np.interp(born, TIME, PATH)), share * weight))
    return force, holding


@pytest.mark.parametrize(("values", "weights"), [([1.0], [1.0]), ([0.71, 1.13], [0.4, 0.6])])
def test_exact_thresholds_with_delay_and_hold_contact_by_contact(values: list[float], weights: list[float]) -> None:
    law = mixture([identical(value) for value in values], weights) if len(values) > 1 else identical(values[0])
    solved = master.solve(Contacts(law, 0.04, delay=Delay(0.31)), PATH, 1e-8, time=TIME)
    force, holding = lumps(values, weights, 0.04, 0.31)
    assert solved.success, solved.message
    np.testing.assert_allclose(solved.force, force, atol=1e-8)
    np.testing.assert_allclose(solved.holding, holding, atol=1e-8)


def test_stiff_contacts_held_at_their_largest_stretch() -> None:
    """Broken ones stay out, so that what holds is a sum over thresholds; right above the stretch hardly any break."""
    law, thermal = gaussian(1.0, 0.2), Thermal("stiff", 0.1, 3.0)
    path, time = np.array([0.9, 0.9, 0.7, 1.0]), np.array([0.9, 20.0, 20.5, 21.1])
    solved = master.solve(Contacts(law, thermal=thermal, delay=Delay(1e3)), path, 1e-8, time=time)
    assert solved.success, solved.message
    x, t = np.append(0.0, path), np.append(0.0, time)
    nodes, weights = np.polynomial.legendre.leggauss(20)
    nodes, weights = 0.5 * (nodes + 1.0), 0.5 * weights
    for n in range(1, x.size):
        least = x[: n + 1].max()

        # in the root of what thresholds lie beyond, on panels graded to where hardly any break
        cuts = np.append(0.0, np.logspace(-5.0, np.log10(1.5), 60))[:, None]
        roots = (cuts[:-1] + np.diff(cuts, axis=0) * nodes).ravel()
        limit, spent = least + roots * roots, np.zeros(roots.size)
        for a, b, lasts in zip(x[:n], x[1 : n + 1], np.diff(t)[:n], strict=True):
            cost = thermal.rate(a, limit) if a == b else thermal.cumulative(b, limit, a) / abs(b - a)
            spent += lasts * cost
        kept = 2.0 * roots * law.pdf(limit) * np.exp(-spent)
        holding = float((np.diff(cuts, axis=0) * weights).ravel() @ kept)
        assert abs(solved.holding[n - 1] - holding) < 1e-8
        assert abs(solved.force[n - 1] - x[n] * holding) < 1e-8


def test_an_exact_threshold_met_just_as_the_path_turns_breaks() -> None:
    """All break for the fourth time just there, come back after 0.2, and break once more at -0.7 on the way back."""
    contacts = Contacts(identical(0.7), delay=Delay(0.2))
    turned = master.solve(contacts, [0.0, 2.5, 1.0], 1e-10, time=[0.0, 2.5, 4.0])
    assert turned.success, turned.message
    np.testing.assert_allclose(turned.force, [0.0, 0.0, -0.4], atol=1e-10)
    np.testing.assert_allclose(turned.holding, [1.0, 0.0, 1.0], atol=1e-10)


@pytest.mark.parametrize(("start", "law"), [(0.0, "stiff"), (1.0 - 1e-6, "soft"), (-0.3, "stiff")])
def test_points_right_at_an_exact_threshold_come_after_its_breaks(start: float, law: str) -> None:
    """On every road, whatever rounding adds to the points: those that have not broken before do so there."""
    thermal = Thermal(law, 0.05)
    contacts = Contacts(identical(1.0), start, thermal=thermal)
    met = 1.0 - start + np.arange(3.0)
    ways = np.diff(np.stack([met - 1e-9, met], axis=1).ravel(), prepend=0.0)
    path = np.cumsum(np.concatenate([np.full(7, ways[0] / 7.0), ways[1:]]))[6:]
    gone = np.exp(-thermal.cumulative(1.0, 1.0, [start, 0.0]))
    for more, time in (([], None), ([path[-1]], [*path, path[-1] + 0.1]), ([path[-1] - 0.1], None)):
        solved = master.solve(contacts, np.append(path, more), 1e-5, time=time)
        assert solved.success, solved.message
        drops = solved.force[0:6:2] - solved.force[1:6:2]
        assert np.abs(drops - gone[0] * gone[1] ** np.arange(3.0)).max() < 2.0 * solved.force_error


def test_births_at_exact_places_bend_the_force_that_they_bring() -> None:
    """Straight on, by lattices, and in time, by panels: right where contacts come back at r = 0.2, the path's end among
    these, and where the strongest that started break."""
    laws = {"thermal": Thermal("soft", 0.0163, 10.0), "delay": Delay(0.31), "reforming": 0.2}
    contacts = Contacts(identical(1.0), 0.378, **laws)
    met = 0.622 + np.array([0.0, 0.31, 1.11, 1.42, 2.22, 2.53])
    path = np.sort(np.concatenate([met - 1e-3, met]))
    straight = master.solve(contacts, path, 1e-7)
    timed = master.solve(contacts, path, 1e-7, time=path)
    assert straight.success and timed.success
    assert np.abs(straight.force - timed.force).max() < straight.force_error + timed.force_error
    assert np.abs(straight.holding - timed.holding).max() < 1e-7

"""Q(x;X) along paths in time: against the solution's own force, an ensemble's histograms, and what is known exactly."""


import numpy as np
import pytest

import eq_model
import master
import origins

WIDE = origins.gaussian(1.0, 0.2)
WARM = origins.Thermal("soft", 0.05, 0.3)
BOTH = origins.mixture([origins.identical(0.6), WIDE], [0.3, 0.7])


def slide_hold_return() -> tuple[np.ndarray, np.ndarray]:
    """Out, two waits, back, another, and on again more slowly."""
    path = np.concatenate([np.linspace(0.0, 2.1, 8), [2.1, 2.1], np.linspace(1.6, 0.6, 5), [0.6, 1.2, 1.9]])
    travel = np.abs(np.diff(path))
    lasts = np.where(travel > 0.0, travel, 5.0)
    lasts[-2:] *= 3.0
    return path, np.append(0.0, np.cumsum(lasts))


PATH, TIME = slide_hold_return()
LAWS = {
    "soft": origins.Contacts(WIDE, origins.gaussian_start(0.0, 0.05), thermal=WARM),
    "the paper's": origins.Contacts(WIDE, 0.1, thermal=origins.Thermal("soft", 0.05, 0.3, closure="paper")),
    "delay": origins.Contacts(WIDE, origins.gaussian_start(0.05, 0.05), delay=origins.Delay(0.3)),
    "again at 0.1": origins.Contacts(WIDE, thermal=WARM, reforming=0.1),
}


def test_exact_values_are_told_apart():
    # all break at X = 1, form again in the hold at 1.2, and are pulled back
    contacts = origins.Contacts(origins.identical(1.0), delay=origins.Delay(0.3))
    path, time = [0.5, 1.2, 1.2, 0.9], [0.5, 1.2, 2.0, 2.3]
    solution = master.solve(contacts, path, 1e-8, time=time)
    for point, stretches in enumerate([[0.5], [], [0.0], [-0.3]]):
        found = solution.distribution(point)
        assert found.delta_positions == pytest.approx(stretches, abs=1e-9)
        assert found.delta_weights == pytest.approx(np.ones(len(stretches)), abs=1e-8)
        assert (found.density([-0.3, 0.0, 0.4]) < 1e-12).all()


@pytest.mark.parametrize(
    ("contacts", "points"),
    [
        (LAWS["soft"], [9, 12, 15, 17]),
        (origins.Contacts(BOTH, 0.05, delay=origins.Delay(0.2)), [3, 5, 7]),
    ],
    ids=["soft", "exact values"],
)
def test_an_ensemble_has_the_same_stretches(contacts, points):
    path, time = PATH[: points[-1] + 1], TIME[: points[-1] + 1]
    solution = master.solve(contacts, path, 1e-4, time=time)
    ensemble = eq_model.simulate(contacts, path, time=time, n_contacts=100_000, seed=3, histograms=points)
    for point, counted in zip(points, ensemble.histograms, strict=True):
        found, edges = solution.distribution(point), counted.stretch_edges[::16]
        width = np.diff(edges)
        seen = (counted.stretches * np.diff(counted.stretch_edges)).reshape(-1, 16).sum(axis=1)
        x = edges[:-1, None] + width[:, None] * (np.arange(100) + 0.5) / 100
        share = found.density(x).mean(axis=1) * width
        # what is shared by many may lie at a bin's edge: its bin and its neighbours are one
        for at, weight in zip(found.delta_positions, found.delta_weights, strict=True):
            bin_ = int(np.searchsorted(edges, at)) - 1
            around = slice(bin_ - 1, bin_ + 2)
            share[bin_], seen[bin_] = share[around].sum() + weight, seen[around].sum()
            share[[bin_ - 1, bin_ + 1]] = seen[[bin_ - 1, bin_ + 1]] = 0.0
        judged = share > 1e-4
        z = (seen - share)[judged] / np.sqrt(share * (1.0 - share) / 100_000)[judged]
        assert judged.sum() > 15 and np.abs(z).max() < 5.0
        assert abs((z**2).sum() - z.size) < 5.0 * np.sqrt(2.0 * z.size)
        assert seen[~judged].sum() < 0.01


def test_what_is_not_known_is_refused_in_one_line():
    solution = master.solve(LAWS["delay"], PATH, 1e-3, time=TIME)
    for point in (-1, PATH.size, 1.5, True):
        with pytest.raises(origins.InputError, match="index of a point"):
            solution.distribution(point)
    spread = master.solve(origins.Contacts(WIDE, reforming=origins.gaussian_start(0.0, 0.05)), [0.3, 0.2], 1e-3)
    with pytest.raises(origins.InputError, match="at many stretches"):
        spread.distribution(1)
    ageing = origins.Contacts(WIDE, ageing=origins.Ageing(final=origins.gaussian(1.5, 0.2), rate=0.1))
    old = master.solve(ageing, [0.3, 0.2], 1e-2)
    with pytest.raises(origins.InputError, match="where contacts age"):
        old.distribution(1)

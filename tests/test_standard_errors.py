"""Standard errors over 300 seeds: z has variance 1 where breaks are many, and not much more where they are few."""

from typing import Any

import numpy as np
import pytest
import scipy.stats

import eq_model
import origins
from origins import Ageing, Contacts, Delay, Thermal

WIDE, SEEDS = origins.gaussian(1.0, 0.2), 300
GAP = origins.mixture([origins.rectangular(0.2, 0.5), origins.rectangular(1.0, 1.7)], [0.3, 0.7])
SOFT, STIFF = Thermal("soft", 0.05, 0.4), Thermal("stiff", 0.05, 0.4)
AGEING = Ageing(origins.gaussian(1.2, 0.1), 0.02)
FORWARD = np.array([0.02, 0.1, 0.4, 0.9, 1.6, 3.0])
TURNING = np.array([0.3, 1.1, 1.9, 1.0, -0.3, -1.0, 0.4])
SCENES: dict[str, tuple[Contacts, np.ndarray, np.ndarray | None]] = {
    "forward": (Contacts(origins.gw_elastic(1.0)), FORWARD, None),
    "start": (Contacts(WIDE, origins.gaussian_start(0.1, 0.1)), FORWARD, None),
    "gap": (Contacts(GAP), FORWARD, None),
    "turning": (Contacts(WIDE), TURNING, None),
    "delay": (Contacts(WIDE, delay=Delay(0.3)), FORWARD, None),
    "linked": (Contacts(WIDE, stiffness="linked"), FORWARD, None),
    "again": (Contacts(WIDE, reforming=origins.gaussian_start(0.0, 0.2)), FORWARD, None),
    "soft": (Contacts(WIDE, thermal=SOFT), FORWARD, None),
    "stiff": (Contacts(WIDE, thermal=STIFF), TURNING, None),
    "hold": (
        Contacts(WIDE, thermal=SOFT),
        np.array([0.5, 0.9, 0.9, 1.4]),
        np.array([0.5, 0.9, 9.0, 9.5]),
    ),
    "ageing": (Contacts(origins.gaussian(0.8, 0.15), ageing=AGEING), FORWARD, None),
    "walls": (
        Contacts(origins.rectangular(0.6, 1.0), ageing=Ageing(scipy.stats.uniform(0.5, 1.0), 0.05)),
        FORWARD,
        None,
    ),
    "grains": (Contacts(origins.growing_grains(1.0, 1.0, age=4.0)), FORWARD, None),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", SCENES)
def test_over_many_seeds(name: str) -> None:
    contacts, path, time = SCENES[name]
    given: dict[str, Any] = {"time": time, "n_contacts": 300}
    runs = [eq_model.simulate(contacts, path, seed=seed, **given) for seed in range(SEEDS)]
    force, errors = (
        np.array([getattr(run, one) for run in runs]) for one in ("force", "force_standard_error")
    )
    off = force - force.mean(axis=0)
    std = np.sqrt(np.square(off / np.maximum(errors, 1e-15)).mean(axis=0))
    # 300 seeds know it to 4 %, and less well where forces are not normal
    mean_square = np.sqrt(np.square(off).mean(axis=0) / np.square(errors).mean(axis=0).clip(1e-30))
    assert (std < 1.5).all() and (mean_square < 1.2).all(), (std, mean_square)
    assert np.mean([run.breaks for run in runs]) > 100 and 0.85 < std[-1] < 1.15, std

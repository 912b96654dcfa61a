"""A slider that contacts catch again while it swings: it rings on them for thousands of turns as others form slowly."""

import time

import numpy as np
import pytest
from scipy import integrate, optimize, stats

import master
import origins
from master.soft.inertia import slider
from master.soft.inertia.delayed import swinging
from master.soft.inertia.delayed.panel import PLACES, TimePanel
from master.soft.inertia.delayed.past_breaks import PastBreaks
from master.soft.inertia.delayed.survival import Survival
from master.soft.inertia.run import Run

WIDE = stats.weibull_min(1.1)


def test_a_slider_rings_on_contacts_while_others_form_in_few_panels() -> None:
    """0.1 kg on 50 N/m: contacts come back after five swings, and catch it at 1e4 <x_s> a second. Half of them break in
    that; on the others it rings 5,000 times until the rest comes back, while one in a hundred forms. All that was
    followed turn by turn, and stopped after 3,000."""
    contacts = origins.Contacts(WIDE, delay=origins.Delay(1.4))
    path = np.array([0.3, 0.86028, 1.0]) * 1e6
    drive = origins.Drive(path, 162.0, None, 1e-6, mass=2e-9, damping=2e-8)
    runs = [Run(contacts, drive, 1e-3, part, time.monotonic() + 300.0) for part in (10.0, 2.0)]
    assert [run.stopped for run in runs] == ["", ""]
    assert [len(run.record.slips) for run in runs] == [1, 1]
    assert all(run.nodes < 4_000 for run in runs)
    assert 1e-6 * abs(runs[0].record.place[-1] - runs[1].record.place[-1]) < 1e-3
    energy = runs[1].energy()
    assert np.abs(energy.missing).max() < 1e-3 * energy.drive[-1]


@pytest.mark.slow
def test_rings_of_which_only_some_ends_are_looked_at_are_those_that_are_followed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    machine = {"spring": 1e-3, "mass": 1e-3, "damping": 2e-4, "velocity": 0.3}
    contacts = origins.Contacts(origins.gaussian(1.0, 0.5), delay=origins.Delay(8.2))
    path = np.linspace(100.0, 2500.0, 49)
    told = master.solve(contacts, path, 5e-3, **machine)
    monkeypatch.setattr(swinging, "RINGS_AT_LEAST", np.inf)
    known = master.solve(contacts, path, 5e-3, **machine)
    assert told.success and known.success and told.slips.drive.size == known.slips.drive.size > 2
    assert np.abs(told.force - known.force).max() < told.force_error + known.force_error
    assert np.abs(told.holding - known.holding).max() < told.holding_error + known.holding_error
    for part in ("damped", "released", "contacts"):
        off = np.abs(getattr(told.energy, part) - getattr(known.energy, part)).max()
        assert off < getattr(told.energy_error, part) + getattr(known.energy_error, part)


def test_when_a_share_is_born() -> None:
    """Breaks 0.1 t² up to t = 2, then the few of a closed motion, 0.05, then 0.45 + (t - 3)/10; a delay of 5."""
    past = PastBreaks(5.0, 1.0)
    for begin, breaks in ((0.0, lambda t: 0.1 * t**2), (3.0, lambda t: 0.45 + 0.1 * (t - 3.0))):
        values = np.zeros((3, PLACES.size))
        values[1] = breaks(begin + 2.0 * PLACES)
        past.add(TimePanel.through(begin, 2.0, values))
    assert past.when_born(4.0, 0.1) == pytest.approx(6.0)
    assert past.when_born(6.0, 0.3) == pytest.approx(7.0)
    assert past.when_born(6.0, 0.33) == pytest.approx(8.0)
    assert past.when_born(7.5, 0.1) == pytest.approx(8.5)
    assert past.when_born(9.0, 0.2) == np.inf


def test_what_contacts_release_up_to_a_stretch() -> None:
    survival = Survival(origins.rectangular(0.0, 2.0))
    assert survival.released(0.6) == pytest.approx(0.6**3 / 12.0)


@pytest.mark.slow
def test_what_the_first_run_found_is_told_where_a_finer_one_rings_for_too_long(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Without damping the start of the drive rings, at a tolerance of which it is no rest, for thousands of turns. A
    coarser run tells the error of the slip, whose begin is known: F_s = X - ∫ y P_c(y) dy, where F' = -K."""
    monkeypatch.setattr(slider, "MOST_TURNS", 300)  # 3,000 take 4 s
    spring = 1e-2
    law, time_of_slip = stats.norm(1.0, 0.2), 100.0
    mass = spring * (time_of_slip / np.pi) ** 2
    speed = 1e-4 * (0.68981939 - 0.52) / (spring * mass) ** 0.5
    end = 0.68981939 / spring + 1.0 + 1.6 * speed * time_of_slip
    contacts = origins.Contacts(origins.gaussian(1.0, 0.2))
    machine = {"spring": spring, "mass": mass, "velocity": speed}
    found = master.solve(contacts, [end], 1e-5, **machine)
    assert not found.success and "rings for too long" in found.message
    begin = optimize.brentq(lambda x: x * law.pdf(x) - 1.0 - spring, 0.5, 0.9)
    force = begin - integrate.quad(lambda x: x * law.pdf(x), 0.0, begin)[0]
    slips = found.slips
    assert slips.drive.size == 1 and 1e-5 < found.force_error < 1e-3
    assert abs(slips.force_before[0] - force) < found.force_error
    assert abs(slips.drive[0] - begin - force / spring) < slips.drive_error
    # half a swing on the spring alone, in units of 2 (F_s - F_k)
    assert slips.drop[0] == pytest.approx(2.0 * (force - 0.52), rel=1e-3)

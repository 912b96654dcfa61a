"""What the shipped scenes of sliders with mass show, with fewer contacts: delays, drive speeds, holds."""

import signal
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure
from solving import same_bits

import eq_model
import master
import origins
import toolkit
from toolkit.command import main
from toolkit.pictures.points import plot_points, plot_points_swing
from toolkit.pictures.run import plot_velocity
from toolkit.pictures.traces import slips_of, with_slips
from toolkit.scene.scene import SHIPPED


def run(name: str, contacts: int, replicas: int = 1, **drive: Any) -> Any:
    """The result of a shipped scene, without a sweep, with so many contacts and other values of its [drive]."""
    tables = tomllib.loads((SHIPPED / f"{name}.toml").read_text())
    tables["eq"] |= {"contacts": contacts, "replicas": replicas}
    tables["drive"] |= drive
    tables.pop("sweep", None)
    return toolkit.run(tables)


def test_a_slip_of_the_tribometer_is_half_a_swing() -> None:
    slips = run("tribometer", 400, 4).eq.slips
    half = np.pi * (0.1 / 50.0) ** 0.5
    # of 400 contacts a few slip by themselves
    assert np.median(slips.duration) == pytest.approx(half, rel=0.1) and slips.replica.size >= 8


def test_the_delay_decides_between_smooth_sliding_and_stick_slip() -> None:
    short = {"turns": [7.5e-6], "times": [7.5], "points": 301}
    smooth, partial, full = (
        run(f"tribometer-{name}", 2000, **short) for name in ("smooth", "partial", "full")
    )
    length, late = smooth.mean_threshold, smooth.time > 3.5
    kinetic = master.steady_state(
        toolkit.load_scene("tribometer-smooth").contacts, velocity=1e-6
    ).force
    # the share of contacts that wait at the drive's speed is 1e-5
    force = smooth.eq.forces[0][late]
    assert force.mean() == pytest.approx(kinetic, rel=0.01) and np.ptp(force) < 0.15 * kinetic
    one, other = ((run.eq.slips.drop, run.eq.slips.force_after) for run in (partial, full))
    slips = partial.eq.slips.drop > 0.1 * length
    assert slips.sum() >= 3 and (one[0][slips] < partial.eq.slips.force_before[slips]).all()
    assert (one[1][slips] > 0.0).all() and (one[1][slips] < 0.3 * kinetic).all()
    # a free swing beyond the drive: damping 20 N s/m beside 2 (1e5 N/m 0.1 kg)^(1/2) = 200
    ratio = 20.0 / 200.0
    beyond = np.exp(-np.pi * ratio / (1.0 - ratio**2) ** 0.5)
    slips = full.eq.slips.drop > 0.5 * length
    assert slips.sum() >= 2
    before = full.eq.slips.force_before[slips]
    np.testing.assert_allclose(-other[1][slips] / before, beyond, atol=0.03)


@pytest.mark.slow  # quick: its mean force with fewer contacts, above
def test_the_tribometer_that_slides_smoothly_has_first_slips_alone() -> None:
    slips = run("tribometer-smooth", 40_000, 2).eq.slips
    assert [*slips.replica] == [0, 1] and slips.drive.max() < 2.7e-6


def test_slips_shorter_than_the_steps_of_the_path_are_drawn() -> None:
    full = run("tribometer-full", 1000, turns=[6e-6], times=[6.0], points=61)
    slips, times = full.eq.slips, full.time
    first = np.flatnonzero(slips.drop > 0.5 * full.mean_threshold)[0]
    place, force = with_slips(times, full.eq.path, full.eq.forces[0], slips_of(full.eq, 0))
    assert force.min() == slips.force_after.min() < full.eq.forces.min()
    assert (np.diff(place) >= 0.0).all() and place.size == times.size + 2 * slips.drop.size
    at = np.flatnonzero(force == slips.force_after[first])[0]
    # a path of 1 um/s
    assert place[at] == pytest.approx(slips.drive[first] / 1e-6 + slips.duration[first], rel=1e-9)


def test_stick_slip_ends_above_a_drive_speed_and_comes_back_at_a_lower_one() -> None:
    done = run("stick-slip-ends", 1000)
    force, amplitude = done.eq.forces[0], []
    for end in range(100, 701, 100):
        amplitude.append(np.ptp(force[(done.time > end - 25.0) & (done.time <= end)]))
    assert min(amplitude[:3]) > 0.4 and max(amplitude[3:5]) < 0.2 and min(amplitude[5:]) > 0.4
    # at 14, where the swings decay, F_k falls with the speed as 1/(1 + 0.1 v); the damping bears the rest
    mean = force[(done.time > 380.0) & (done.time <= 400.0)].mean()
    assert mean == pytest.approx(0.52 / 2.4 + 0.013 * 14.0, rel=0.01)
    # the picture marks all slips, which points of the path show, each near a largest speed of these
    axes, slips = plot_velocity(Figure().subplots(), done), done.eq.slips
    (marks,) = (line for line in axes.lines if line.get_label() == "top speed of a slip, EQ")
    speed = np.interp(marks.get_xdata(), done.time, done.eq.velocities[0])
    assert slips.drive.size == speed.size > 40
    assert np.abs(speed / slips.top_speed - 1.0).max() < 0.02


def test_the_force_after_a_hold_with_mass_grows_until_all_contacts_hold() -> None:
    done = run("slide-hold-slide-mass", 4000, 2)
    time, contacts = done.time, done.eq.contact_forces.mean(axis=0)
    peaks = [contacts[(time >= begin) & (time < begin + 4.0)].max() for begin in (10.2, 18.7, 31.7)]
    assert peaks[0] + 0.05 < peaks[1] and peaks[1] + 0.02 < peaks[2]
    asked = toolkit.load_scene("slide-hold-slide-mass")
    way = np.r_[20.0, 20.0, np.linspace(20.02, 24.0, 200)]
    times = np.r_[10.0, 15.0, 15.0 + (way[2:] - 20.0) / 2.0]
    rigid = master.solve(asked.contacts, way, 1e-5, time=times).force[2:].max()
    # the slider rests while its contacts form, but those that hold were stretched less as it slowed down
    assert 0.9 * rigid < peaks[2] < 1.01 * rigid
    held = done.eq.holding[time <= 31.7][-1]
    assert held == 1.0 and 0.4 < done.eq.holding[time <= 26.7][-1] < 0.6


@pytest.mark.slow  # quick: both solvers beside a mass, in test_mass_agreement.py
def test_a_hold_with_mass_by_both_solvers() -> None:
    """At all points: 8,000 contacts scatter by some 6e-3, and slip late by some 2e-3."""
    done = run("slide-hold-slide-mass", 4000, 2)
    asked = toolkit.load_scene("slide-hold-slide-mass")
    pulled = {name: getattr(asked.drive, name) for name in ("spring", "mass", "damping", "time")}
    exact = master.solve(asked.contacts, asked.path, 1e-3, **pulled)
    assert exact.success and np.abs(done.eq.force - exact.force).max() < 0.012


def test_a_sweep_over_drive_speeds_has_the_swings_and_where_they_end() -> None:
    tables = tomllib.loads((SHIPPED / "critical-speed.toml").read_text())
    tables["eq"] |= {"contacts": 400}
    tables["drive"] |= {"to": 2500.0, "points": 2001}
    tables["sweep"] = {"drive.velocity": [8.0, 16.0]}
    done = toolkit.run(tables)
    swept: Any = done.sweep
    (band,) = plot_points_swing(Figure().subplots(), done).patches
    assert band.get_x() == 8.0 and band.get_label() == "swings end between 8 and 16"
    # beyond, the force before a slip is that of the first transient, and is not drawn
    before = plot_points(Figure().subplots(), done, "kinetic_force").lines[0]
    assert np.isfinite(swept["eq_force_before_slip"]).all()
    assert [*np.isfinite(before.get_ydata())] == [True, False]
    alone = run("critical-speed", 400, 2, to=2500.0, points=2001, velocity=8.0)
    swings = np.ptp(alone.eq.forces[:, -500:], axis=1)
    assert swept["eq_force_swing"][0] == swings.mean()
    assert swept["eq_force_swing_error"][0] == swings.std(ddof=1) / 2**0.5
    assert swept["eq_force_swing"][0] > 0.5 and swept["eq_force_swing"][1] < 0.1


def test_damping_and_delay_decide_how_far_the_force_falls() -> None:
    contacts, spring, mass = origins.gaussian(1.0, 0.2), 0.01, 0.05
    kinetic, critical = 0.52, 2.0 * (spring * mass) ** 0.5  # <x_s²>/2<x_s>
    for ratio in (0.05, 0.2):
        beyond = 1.0 + np.exp(-np.pi * ratio / (1.0 - ratio**2) ** 0.5)
        for delay, held in ((None, kinetic), (origins.Delay(500.0), 0.0)):
            law = origins.Contacts(contacts, delay=delay)
            pulled = {"spring": spring, "mass": mass, "damping": ratio * critical, "velocity": 0.01}
            # the drive goes to 80 <x_s>, a little farther than the first slip
            run = eq_model.simulate(
                law, [0.0, 80.0], **pulled, n_contacts=20_000, n_replicas=1, seed=1
            )
            first = np.argmax(run.slips.drop)
            whole = (run.slips.force_before[first] - held) * beyond
            assert run.slips.drop[first] == pytest.approx(whole, rel=0.02)


# The command, in a process that ends itself by kill -9 once it has written its second checkpoint.
KILLED = """
import os, signal, sys
from toolkit.command import main
from toolkit.running import checkpoint

real, written = checkpoint.write_state, []

def write_state(*of):
    real(*of)
    written.append(of)
    if len(written) == 2:
        os.kill(os.getpid(), signal.SIGKILL)

checkpoint.write_state = write_state
main(sys.argv[1:])
"""


@pytest.mark.slow  # quick: killed in turn, and replicas after a signal, in test_survives.py
def test_a_scene_with_mass_killed_midway_goes_on_to_the_same_bits(
    python: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    words = ["tribometer-full", "--set", "eq.contacts=300", "--set", "eq.replicas=5"]
    words = ["run", *words, "--checkpoint", "1e-9", "--out", "out"]
    killed = python(KILLED, *words)
    assert killed.returncode == -signal.SIGKILL, killed.stderr
    monkeypatch.chdir(tmp_path)
    # a picture takes longer than all else
    monkeypatch.setattr("toolkit.pictures.run.save_picture", lambda result, path: path.touch())
    assert main(words) == 0
    assert "600 contacts are done" in capsys.readouterr().err
    found = toolkit.load(tmp_path / "out").eq
    whole = run("tribometer-full", 300, 5).eq
    same_bits(found, whole)
    assert found.slips.drop.size > 5 and not (tmp_path / "out" / "checkpoint").exists()

"""The numbers and the picture of docs/rate-and-state.md: python docs/rate_and_state.py"""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from scipy import stats

import eq_model
import master
import origins
from toolkit.pictures.axes import OKABE_ITO, name_axis
from toolkit.rate_state.judge import Judged, judge
from toolkit.rate_state.picture import draw_rests, draw_steps
from toolkit.rate_state.words import page
from toolkit.scene.scene import load_scene

PICTURES = Path(__file__).parent / "pictures"
SCENE, WEAKENING = "rate-state", "rate-state-weakening"
KELVIN = (200.0, 300.0, 400.0)
DELAYED = origins.Contacts(origins.gaussian(1.0, 0.2), delay=origins.Delay(0.1))


def draw_speeds(axes: Any) -> None:
    """F_k against ln v at three temperatures, and the slope α F_k(∞) of each."""
    speeds = np.geomspace(1e-9, 100.0, 56)
    for number, kelvin in enumerate(KELVIN):
        scene = load_scene(SCENE, False, changes={"contacts.thermal.kelvin": kelvin})
        contacts, scale = scene.contacts, scene.scale
        cold = float(master.kinetic_curve(contacts.replace(thermal=None)).force) * scale.force
        width = dict(contacts.thermal.own)["width"]
        force = master.kinetic_curve(contacts, speeds).force * scale.force
        axes.plot(speeds, force, color=OKABE_ITO[number], label=f"{kelvin:.0f} K, α = {width:.2f}")
        middle = speeds.size // 3
        line = force[middle] + width * cold * np.log(speeds / speeds[middle])
        axes.plot(speeds, line, ":", color=OKABE_ITO[number], lw=1.0)
        slope = (force[middle + 1] - force[middle - 1]) / np.log(
            speeds[middle + 1] / speeds[middle - 1]
        )
        print(
            f"{kelvin:.0f} K: slope {1e3 * slope:.3f} mN, {slope / (width * cold):.4f} of α F_k(∞)"
        )
    axes.axhline(cold, color="0.5", lw=0.8, label="without heat")
    axes.set_xscale("log")
    axes.set_ylim(0.0, 1.1 * cold)
    name_axis(axes.xaxis, "speed $v$", "m/s")
    name_axis(axes.yaxis, "kinetic force $F_k$", "N")
    axes.legend(fontsize="small", title="dotted: slope $α\\,F_k(∞)$", title_fontsize="small")


def draw(heated: Judged, weakening: Judged) -> None:
    """Speeds and steps with heat; below, steps and rests of contacts that strengthen."""
    figure = Figure(figsize=(12, 10.4), layout="constrained")
    (speeds, steps), (falling, rests) = figure.subplots(2, 2)
    draw_speeds(speeds)
    draw_steps(steps, heated)
    draw_steps(falling, weakening)
    draw_rests(rests, weakening)
    figure.savefig(PICTURES / "rate_and_state.png", dpi=100)


def swings(spring: float) -> str:
    """Standard deviations of the spring's force in ten mean thresholds, early and late, of a slider of 400,000 contacts
    with a delay, by the ensemble. It comes to v = 1 slowly, from stretches near those of steady sliding."""
    contacts = DELAYED.replace(start=stats.uniform(0.0, 0.95))
    speeds = np.geomspace(0.02, 1.0, 40)
    drive = 0.475 / spring + np.r_[0.0, np.cumsum(np.full(40, 0.5))]
    swung = drive[-1] + np.arange(0.05, 60.0, 0.05)
    times = np.r_[0.0, np.cumsum(0.5 / speeds)]
    arrival = 1e-9 + np.r_[times, times[-1] + swung - drive[-1]]
    given: dict[str, Any] = {"spring": spring, "slip": "instant", "time": arrival}
    path = np.r_[drive, swung]
    run = eq_model.simulate(contacts, path, **given, n_contacts=400_000, n_replicas=1, seed=1)
    force = np.asarray(run.force)[41:]
    return f"{force[:200].std():.4f} early, {force[-200:].std():.4f} late"


def print_springs() -> None:
    """Critical springs of contacts with a delay: by rate and state, by the solved answer, and what sliders do."""
    found = master.rate_state(DELAYED, 1.0, decades=0)
    solved, off = found.critical_spring_solved, found.critical_spring_solved_error
    print(f"delay: (b - a)/D_c = {found.critical_spring:.3f}, solved {solved:.3f} ± {off:.3f}")
    for spring in (0.35, 0.42, 0.51, 0.6):
        print(f"spring {spring}: swings {swings(spring)}")


def print_weakening() -> None:
    """The ageing law beside steps of the scene whose friction falls with the speed; and what a slider does on springs
    near the critical one, by the master equation. It comes down from a speed at which contacts have no time to
    strengthen, and goes on at 1 µm/s."""
    scene = load_scene(WEAKENING, False)
    found = master.rate_state(scene.contacts, scene.sliding, decades=0, evolution="ageing")
    print(
        f"ageing law: D_c = {1e9 * found.slip_distance.value:.2f} nm, off by {found.misfit.share:.1%} of b"
    )
    for newtons_per_metre in (1.09e6, 1.33e6):
        spring = newtons_per_metre / scene.scale.spring
        speeds, onward = np.geomspace(1e-3, scene.sliding, 30), 2e-9 * np.arange(1, 151)
        slid = np.r_[0.25 / newtons_per_metre + 6e-8, 8e-9 * np.arange(1, 30)]
        slid[1:] += slid[0]
        times = np.cumsum(np.diff(slid, prepend=0.0) / speeds)
        path = np.r_[0.0, slid, slid[-1] + onward]
        arrival = np.r_[0.0, times, times[-1] + onward / scene.sliding]
        given: dict[str, Any] = {"spring": spring, "slip": "instant", "time": arrival}
        run = master.solve(scene.contacts, path, 1e-3, **given)
        slips, newtons = run.slips, 1e3 * scene.scale.force
        force = newtons * np.r_[run.force[-50:], slips.force_before, slips.force_after]
        error = newtons * scene.contacts.mean_threshold * run.force_error
        told = f"{force.min():.2f} to {force.max():.2f} mN, error {error:.2g}"
        print(f"spring {newtons_per_metre:.3g} N/m: {told}")


def main() -> None:
    heated, weakening = (
        judge(load_scene(name, False), lambda what: None) for name in (SCENE, WEAKENING)
    )
    for judged in (heated, weakening):
        print("\n".join([*page(judged), ""]))
    draw(heated, weakening)
    print_springs()
    print_weakening()


if __name__ == "__main__":
    main()

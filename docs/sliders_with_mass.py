"""The numbers and the picture of docs/sliders-with-mass.md: python docs/sliders_with_mass.py"""

import tomllib
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import eq_model
import master
import origins
import toolkit
from toolkit.pictures.axes import MARKERS, OKABE_ITO, legend_above
from toolkit.scene.scene import SHIPPED

PICTURES = Path(__file__).parent / "pictures"
THRESHOLDS, KINETIC = origins.gaussian(1.0, 0.2), 0.52  # F_k = <x_s²>/2<x_s>
# of the scene critical-speed: delay, damping, K times half a period of mass and spring
DELAY, DAMPING, STIFFNESS = 0.1, 0.013, 0.1


class Slips(NamedTuple):
    """What slips take of the force before them, means without the small ones, and how fast they are at most."""

    share: float
    top_speed: float
    number: int


def tribometer(delay: float, contacts: int = 2000) -> Slips:
    """Slips of the scene tribometer-smooth with another delay, those of above a fifth of a mean threshold."""
    tables = tomllib.loads((SHIPPED / "tribometer-smooth.toml").read_text())
    tables["contacts"]["delay"]["time"] = delay
    tables["drive"] |= {"turns": [15e-6], "times": [15.0], "points": 1501}  # as of its sisters
    tables["eq"] |= {"contacts": contacts, "replicas": 1}
    done = toolkit.run(tables)
    slips = done.eq.slips
    large = slips.drop > 0.2 * done.mean_threshold
    if not large.any():
        return Slips(0.0, float(slips.top_speed.max()), 0)
    share = (slips.drop / slips.force_before)[large]
    return Slips(float(share.mean()), float(slips.top_speed[large].mean()), int(large.sum()))


def machine(half: float) -> tuple[float, float]:
    """Spring and mass whose half period is `half`, K times that STIFFNESS."""
    spring = STIFFNESS / half
    return spring, spring * (half / np.pi) ** 2


def swing(speed: float, half: float, contacts: int = 500, seed: int = 1, swings: int = 40) -> float:
    """Largest less smallest force of the spring in the last four of so many periods from rest, by the ensemble."""
    spring, mass = machine(half)
    end = speed * swings * 2.0 * half
    path = np.linspace(0.0, end, 50 * swings + 1)[-201:]
    law = origins.Contacts(THRESHOLDS, delay=origins.Delay(DELAY))
    pulled = {"spring": spring, "mass": mass, "damping": DAMPING, "velocity": speed}
    run = eq_model.simulate(law, path, **pulled, n_contacts=contacts, n_replicas=1, seed=seed)
    return float(np.ptp(run.forces))


def swing_without_memory(speed: float, half: float = 5.0, swings: int = 60) -> float:
    """The same of a slider whose friction is F_k at its present speed, by scipy."""
    spring, mass = machine(half)

    def rates(_: float, state: np.ndarray) -> list[float]:
        force, velocity = state
        # at rest any force up to F_k: a speed of 0.005 <x_s> takes it to 3/4
        friction = KINETIC * np.tanh(velocity / 0.005) / (1.0 + DELAY * abs(velocity))
        return [spring * (speed - velocity), (force - friction - DAMPING * velocity) / mass]

    end = 2.0 * half * swings
    last = np.linspace(end - 8.0 * half, end, 801)
    return float(
        np.ptp(
            solve_ivp(
                rates, (0.0, end), [0.0, 0.0], method="Radau", rtol=1e-6, atol=1e-9, t_eval=last
            ).y[0]
        )
    )


def last_swings(of: object, low: float = 11.0, high: float = 15.0, halvings: int = 6) -> float:
    """The speed at which swings of above 0.3 end, by halving; off by (high - low)/2^(halvings + 1) at most."""
    for _ in range(halvings):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if of(middle) > 0.3 else (low, middle)  # type: ignore[operator]
    return 0.5 * (low + high)


def closed_speeds() -> tuple[float, float]:
    """Where smooth sliding becomes unstable, γ + dF_k/dv = 0; where swings that just come to rest keep their energy."""
    smooth = ((KINETIC * DELAY / DAMPING) ** 0.5 - 1.0) / DELAY

    def gained(speed: float) -> float:
        waits = DELAY * speed
        return KINETIC / waits * ((1.0 + waits) / (1.0 + 2.0 * waits) ** 0.5 - 1.0) - DAMPING * (
            speed / 2.0
        )

    return smooth, brentq(gained, 2.0, 100.0)


def print_delays() -> None:
    for delay in (1e-7, 1e-6, 3e-6, 1e-5, 3e-5, 1e-4, 1e-3, 1e-1):
        found = tribometer(delay)
        print(
            f"delay {delay:.0e} s: {found.number} slips take {found.share:.2f} of the force, "
            f"top speed {found.top_speed:.1e} m/s, delay x top speed {delay * found.top_speed / 9.13e-9:.2g} <x_s>"
        )


def print_speeds() -> None:
    """The drive speed above which stick-slip ends: ensemble for three half periods, extrapolated, scipy, closed."""
    found = []
    for half in (5.0, 10.0, 20.0):
        ends = [last_swings(lambda v, s=seed, h=half: swing(v, h, seed=s)) for seed in range(1, 5)]
        # halving leaves an even error of 2^-7 of the range
        error = np.hypot(np.std(ends, ddof=1) / 2.0, 4.0 / 2**7 / 3**0.5)
        found.append((half, np.mean(ends), error))
        print(f"half a period {half:g}: stick-slip ends at {np.mean(ends):.2f} ± {error:.2f}")
    (_, one, _), (_, other, error) = found[1:]
    print(f"without end, from the last two by 1/T: {2.0 * other - one:.2f} ± {2.2 * error:.2f}")
    print(f"friction without memory, by scipy: {last_swings(swing_without_memory):.2f}")
    smooth, kept = closed_speeds()
    print(
        f"swings that just come to rest: {kept:.2f}; smooth sliding is unstable below {smooth:.2f}"
    )


def first_drops(
    mass: float, damping: float, delay: float | None, contacts: int = 20_000
) -> np.ndarray:
    """How far the force falls in the first two slips, 0 for none, on a spring of 0.01 and a slow drive."""
    law = origins.Contacts(THRESHOLDS, delay=None if delay is None else origins.Delay(delay))
    pulled = {"spring": 0.01, "mass": mass, "damping": damping, "velocity": 0.01}
    run = eq_model.simulate(law, [0.0, 150.0], **pulled, n_contacts=contacts, n_replicas=1, seed=1)
    drops = run.slips.drop[run.slips.drop > 0.15]
    return np.r_[drops, 0.0, 0.0][:2]


def print_rules() -> None:
    """Falls of the force by slip rule, and of sliders with mass that should follow the same."""
    law = origins.Contacts(THRESHOLDS)
    for rule in ("instant", "reform-after", "reset"):
        found = master.solve(law, [0.0, 150.0], 1e-6, spring=0.01, slip=rule)
        print(f"{rule}: falls of {np.round(found.slips.drop[:2], 3)}")
    for name, mass, damping, delay in (
        ("overdamped, no delay", 1e-5, 0.05, None),
        ("overdamped, delay of 500, a slip takes some 5 x 5", 1e-5, 0.05, 500.0),
        ("a tenth of critical, no delay", 0.05, 0.2 * (0.01 * 0.05) ** 0.5, None),
        ("a tenth of critical, delay of 500", 0.05, 0.2 * (0.01 * 0.05) ** 0.5, 500.0),
    ):
        print(f"{name}: falls of {np.round(first_drops(mass, damping, delay), 3)}")


def print_long_delays() -> None:
    """The first and the tenth drop of a slider without mass whose contacts wait, by the ensemble, after a delay in
    which the spring regains less than a slip takes, and after a longer one."""
    wide, spring = origins.gaussian(1.0, 0.4), 0.252
    for delay in (1.0, 30.0):
        path = np.linspace(0.0, 14.0 * (delay + 2.0 + 1.0 / spring), 50)
        law = origins.Contacts(wide, delay=origins.Delay(delay))
        pulled = {"spring": spring, "slip": "reform-after", "velocity": 1.0}
        run = eq_model.simulate(law, path, **pulled, n_contacts=100_000, n_replicas=1, seed=1)
        drops = run.slips.drop[run.slips.drop > 0.1]
        print(f"delay {delay:g}: drops of slip 1 and 10: {drops[0]:.3f}, {drops[9]:.3f}")


def draw_speeds() -> None:
    """Swings against the drive's speed: the ensemble, scipy without memory, 2 v (K M)^(1/2), and the closed speeds."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6.4, 4.0), layout="constrained")
    ax = figure.subplots()
    speeds = np.array(
        [1.0, 2.0, 3.0, 4.0, 6.0, 8.0, 10.0, 11.0, 11.5, 12.0, 12.5, 13.0, 14.0, 16.0]
    )
    for half, ink, mark in zip((5.0, 20.0), OKABE_ITO[1:], MARKERS, strict=False):
        runs = [[swing(speed, half, seed=seed) for seed in (1, 2)] for speed in speeds]
        label = f"500 contacts, half a period {half:g}"
        ax.plot(speeds, np.mean(runs, axis=1), mark, ms=5, mfc="none", color=ink, label=label)
    fine = np.r_[speeds[:-2], 12.9, 13.1, 14.0, 16.0]
    fine.sort()
    without = [swing_without_memory(speed) for speed in fine]
    ax.plot(fine, without, color=OKABE_ITO[0], lw=1.3, label="friction $F_k$(present speed)")
    spring, mass = machine(5.0)
    line = 2.0 * speeds * (spring * mass) ** 0.5
    ax.plot(speeds, line, ":", color="0.4", lw=1.2, label=r"$2v\,(KM)^{1/2}$: just comes to rest")
    smooth, kept = closed_speeds()
    ax.axvline(smooth, color="0.4", lw=1, ls="--", label="smooth sliding unstable below")
    ax.axvline(kept, color="0.4", lw=1, ls="-.", label="swings lose energy above")
    mean = r"\langle x_s\rangle"
    force = rf"largest less smallest spring force ($N_c\langle k\rangle{mean}$)"
    ax.set(ylabel=force, ylim=(0, 1.2))
    ax.set_xlabel(
        rf"speed of the drive $v$ (${mean}$ in a unit of time, of which the delay is {DELAY})"
    )
    legend_above(ax, "stick-slip ends above a drive speed", 90)
    figure.savefig(PICTURES / "critical_speed.png", dpi=130)


def main() -> None:
    print_delays()
    print_rules()
    print_long_delays()
    print_speeds()
    draw_speeds()


if __name__ == "__main__":
    main()

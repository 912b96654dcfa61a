"""Public functions of master beside `solve`: curves, lines, spectra, the paper's schemes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

import master
import origins
from oracle.case import Answer, Case, MakeContacts, along_turns, few, steady_force

NARROW, WIDE = origins.gaussian(1.0, 0.05), origins.gaussian(1.0, 0.2)
SCHEME_CLAIM = 1e-9  # the paper's schemes are sums of a fixed order: only round-off may differ


def function_cases() -> Iterator[Case]:
    """Cases of every public function but solve, steady_state and propensity of ordinary laws."""
    yield from curve_cases()
    yield from line_cases()
    yield from spectrum_cases()
    yield from speed_cases()
    yield from scheme_cases()


def warm(rate: str, temperature: float, closure: str = "exact", **laws: Any) -> MakeContacts:
    """Narrow Gaussian thresholds at a temperature."""
    thermal = origins.Thermal(rate, temperature, closure=closure)
    return lambda: origins.Contacts(**({"thresholds": NARROW, "thermal": thermal} | laws))


def ageing(closure: str, **laws: Any) -> MakeContacts:
    """Thresholds of 0.5 that become 1, the paper's Fig. A05."""
    law = origins.Ageing(origins.gaussian(1.0, 0.01), 1.0, closure)
    return lambda: origins.Contacts(origins.gaussian(0.5, 0.1), ageing=law, **laws)


def growing(**laws: Any) -> MakeContacts:
    """Grains that grow, as in the table of docs/laws.md."""
    return lambda: origins.Contacts(origins.growing_grains(1.0, 1.0, age=4.0), **laws)


def curve(make: MakeContacts, velocity: Any, **others: Any) -> Callable[[], Answer]:
    """Force and holding fraction of master.kinetic_curve."""

    def answer() -> Answer:
        contacts = make()
        found = master.kinetic_curve(contacts, velocity, **others)
        force = found.force / contacts.mean_threshold
        values = np.concatenate([force.ravel(), found.holding.ravel()])
        claims = np.concatenate([found.force_error.ravel(), found.holding_error.ravel()])
        return Answer(values, claims, bool(np.all(found.success)))

    return answer


def curve_cases() -> Iterator[Case]:
    """F_k along speeds, temperatures, rates of ageing and delays, by every road there is."""
    speeds = np.geomspace(1e-3, 10.0, 9)
    table = {
        "soft": curve(warm("soft", 0.05), speeds),
        "stiff": curve(warm("stiff", 0.05), speeds),
        "soft, creep": curve(warm("soft", 0.3), np.geomspace(1e-8, 1e-3, 6)),
        "soft, paper's closure": curve(warm("soft", 0.3, "paper"), speeds),
        "stiff, paper's closure": curve(warm("stiff", 0.3, "paper"), speeds),
        "wide": curve(warm("soft", 0.1, thresholds=origins.gw_elastic(1.6)), speeds),
        "jumps": curve(warm("soft", 0.1, thresholds=origins.rectangular(0.3, 1.7)), speeds),
        "exact value": curve(warm("stiff", 0.1, thresholds=origins.identical(1.0)), speeds),
        "linked": curve(warm("soft", 0.1, stiffness="linked"), speeds),
        "heat and delay": curve(warm("soft", 0.1, delay=origins.Delay(0.3)), speeds),
        "heat, re-forming at one": curve(warm("soft", 0.1, reforming=0.2), speeds),
        "heat, re-forming at many": curve(
            warm("soft", 0.1, reforming=origins.gaussian_start(0.1, 0.05)), speeds
        ),
        "cold, re-forming at many": curve(
            lambda: origins.Contacts(WIDE, reforming=origins.gaussian_start(0.1, 0.05)), speeds[:2]
        ),
        "speeds and temperatures": curve(
            warm("soft", 0.1), speeds[::3, None], temperature=[0.0, 0.01, 0.1, 1.0]
        ),
        "temperatures": curve(warm("stiff", 1.0), 0.1, temperature=np.geomspace(1e-3, 10.0, 9)),
        "delays": curve(lambda: origins.Contacts(WIDE), 1.0, delay=np.linspace(0.0, 3.0, 7)),
        "ageing": curve(ageing("exact"), np.geomspace(3.0, 1e5, 9)),
        "ageing, paper's closure": curve(ageing("paper"), np.geomspace(1e2, 1e6, 9)),
        "rates of ageing": curve(ageing("exact"), 1.0, rate=[1e-4, 1e-3, 1e-2]),
        "grains": curve(growing(), [0.3, 1.0, 3.0]),
        "grains, soft": curve(growing(thermal=origins.Thermal("soft", 0.1)), [0.3, 1.0]),
    }
    for name, answer in table.items():
        yield Case(f"F_k {name}", "curves", answer)
    for diffusion in (1e-5, 3e-4, 1e-2):
        answer = steady_force(ageing("paper"), velocity=1.0 / diffusion)
        yield Case(f"Q15 steady D_X={diffusion:g}", "ageing", answer)


def line(
    make: MakeContacts, velocity: Any, tolerance: float, **others: Any
) -> Callable[[], Answer]:
    """K* of master.phase_line."""

    def answer() -> Answer:
        found = master.phase_line(make(), velocity, tolerance=tolerance, **others)
        spring, error = found.critical_spring.ravel(), found.critical_spring_error.ravel()
        return Answer(spring, error, bool(np.all(found.success)))

    return answer


def line_cases() -> Iterator[Case]:
    """K* along speeds and the rest, of every law that tells the speed."""
    speeds = np.geomspace(3e-2, 3.0, 3)
    table = {
        "cold": line(lambda: origins.Contacts(NARROW), 1.0, 1e-8),
        "cold, started": line(
            lambda: origins.Contacts(WIDE, origins.gaussian_start(0.1, 0.05)), 1.0, 1e-8
        ),
        "linked": line(lambda: origins.Contacts(WIDE, stiffness="linked"), 1.0, 1e-8),
        "re-forming": line(lambda: origins.Contacts(WIDE, reforming=0.1), 1.0, 1e-8),
        "delays": line(lambda: origins.Contacts(WIDE), 1.0, 1e-6, delay=[0.0, 0.1, 1.0]),
        "soft": line(warm("soft", 0.02), speeds, 1e-6),
        "stiff": line(warm("stiff", 0.02), speeds, 1e-6),
        "soft, paper's closure": line(warm("soft", 0.1, "paper"), speeds, 1e-6),
        "temperatures": line(warm("soft", 0.1), 1.0, 1e-6, temperature=[0.0, 0.03, 0.3]),
        "hot": line(warm("soft", 0.3), 1.0, 1e-8),
        "ageing": line(ageing("exact"), [1e2, 1e4], 1e-4),
        "grains": line(growing(), [0.5, 1.0], 1e-6),
        "grains, soft": line(growing(thermal=origins.Thermal("soft", 0.1)), 1.0, 1e-6),
    }
    for name, answer in table.items():
        yield Case(f"K* {name}", "curves", answer)


def spectrum(make: MakeContacts, n_roots: int = 6, velocity: float = 1.0) -> Callable[[], Answer]:
    """Roots, amplitudes and the sum of the terms of master.decoherence_spectrum."""

    def answer() -> Answer:
        contacts = make()
        unit = contacts.mean_threshold
        found = master.decoherence_spectrum(contacts, velocity=velocity, n_roots=n_roots)
        roots, amplitudes = found.roots * unit, found.amplitude / unit
        place = np.linspace(0.0, 12.0, 9) * unit
        values = [roots.real, roots.imag, amplitudes.real, amplitudes.imag]
        own = found.roots_error * unit, found.amplitude_error / unit
        claims = [own[0], own[0], own[1], own[1]]
        values += [found.period / unit, found.decay_length / unit, found.force(place) / unit]
        claims += [found.period_error / unit, found.decay_length_error / unit]
        claims.append(found.force_error(place))
        # the last digits of the roots and of what is printed of them are round-off
        return Answer(np.concatenate(values), np.concatenate(claims) + 1e-12, True)

    return answer


def spectrum_cases() -> Iterator[Case]:
    """The spectrum of plain and wide laws, of each law of a contact, and of long waits."""
    from scipy import stats

    peaks = origins.mixture([origins.gaussian(m, 1e-3) for m in (0.95, 1.05)], [0.5, 0.5])
    start = origins.gaussian_start(0.1, 0.025)
    table: dict[str, tuple] = {
        "narrow": (lambda: origins.Contacts(NARROW),),
        "wide": (lambda: origins.Contacts(WIDE),),
        "started": (lambda: origins.Contacts(WIDE, start),),
        "two peaks": (lambda: origins.Contacts(peaks, start), 20),
        "gw_elastic": (lambda: origins.Contacts(origins.gw_elastic(1.6)), 3),
        "rectangular": (lambda: origins.Contacts(origins.rectangular(0.5, 1.5)), 3),
        "persson": (lambda: origins.Contacts(origins.persson(1.0, 0.5)), 3),
        "gamma": (lambda: origins.Contacts(stats.gamma(6.0, scale=1.0 / 6.0)), 2),
        "delay": (lambda: origins.Contacts(WIDE, delay=origins.Delay(0.4)),),
        "long delay": (lambda: origins.Contacts(WIDE, delay=origins.Delay(20.0)),),
        "re-forming": (lambda: origins.Contacts(WIDE, reforming=0.1),),
        "linked": (lambda: origins.Contacts(WIDE, stiffness="linked"),),
        "soft": (warm("soft", 0.05), 4),
        "soft, paper's closure": (warm("soft", 0.05, "paper"), 3),
        "ageing": (ageing("exact"), 3, 1e3),
        "grains": (growing(), 2),
    }
    for name, asked in table.items():
        yield Case(f"spectrum {name}", "spectrum", spectrum(*asked))


def speed_cases() -> Iterator[Case]:
    """The speed above which ageing no longer lets a spring slip (Fig. A06), in both closures."""
    for closure, spring, slowest, fastest in (
        ("paper", 3.5, 1.0, 4.0),
        ("exact", 3.5, 2.5, 7.0),
        ("exact", 4.0, 2.5, 7.0),
    ):
        law = origins.Ageing(origins.gaussian(1.0, 0.02), 5e-4, closure)

        def answer(law=law, spring=spring, slowest=slowest, fastest=fastest) -> Answer:
            fresh, start = origins.gaussian(0.5, 0.05), origins.gaussian_start(0.02, 0.01)
            contacts = origins.Contacts(fresh, start, ageing=law)
            found = master.critical_velocity(contacts, spring, slowest, fastest)
            # where the drop is steepest it is flat: X there is known to the root of what v_c is
            claims = [found.velocity_error, np.sqrt(found.velocity_error)]
            return Answer([found.velocity, found.position], claims, True)

        yield Case(f"v_c {closure} K={spring}", "v_c", answer)


def scheme_cases() -> Iterator[Case]:
    """The paper's own explicit schemes, forward and on loops."""
    try:
        from master.paper.explicit import explicit
        from master.paper.explicit_loop import explicit_loop
    except ImportError:  # the older tree, where these stand one folder above
        from master.explicit import explicit
        from master.explicit_loop import explicit_loop

    start = origins.gaussian_start(0.1, 0.025)
    path, loop = np.linspace(0.0, 4.0, 81), along_turns([0.0, 3.0, -3.0, 3.0], 61)
    delayed = {"delay": origins.Delay(0.4)}
    heated = {"thermal": origins.Thermal("soft", 0.1, closure="paper")}
    for breaking in ("survival", "printed"):
        for name, laws in {"plain": {}, "delay": delayed, "heat": heated}.items():

            def forward(breaking: Any = breaking, laws: dict = laws) -> Answer:
                found = explicit(origins.Contacts(WIDE, start, **laws), path, 0.01, breaking)
                return Answer([*few(found.force), *few(found.holding, 5)], SCHEME_CLAIM, True)

            yield Case(f"explicit {breaking} {name}", "paper's schemes", forward)

        def turning(breaking: Any = breaking) -> Answer:
            found = explicit_loop(origins.Contacts(WIDE, start), loop, 0.01, breaking)
            return Answer([*few(found.force), *few(found.holding, 5)], SCHEME_CLAIM, True)

        yield Case(f"explicit_loop {breaking}", "paper's schemes", turning)

"""Every kind of scene that force_error makes its promise for: laws, starts and drives in turn."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import scipy.stats
from phase_type import coxian, gaussian_force, hyper_erlang

import origins
from promise.draw import POINTS, Draw, Scene


def narrow_gaussian(draw: Draw) -> Scene:
    """Gaussian thresholds and starts: the force in closed form."""
    unit, std = draw.unit, draw.log(0.01, 0.11, 1e-4, 0.11)
    start, start_std = draw.even(-0.05, 0.1), draw.log(0.003, 0.03, 1e-4, 0.03)
    begins = origins.gaussian_start(unit * start, unit * start_std)
    contacts = origins.Contacts(origins.gaussian(unit, unit * std), begins)

    def exact(x: Any) -> Any:
        return unit * gaussian_force(x / unit, 1.0, std, start, start_std)

    return Scene(contacts, draw.path(20.0, unit), draw.tolerance(), exact)


def phase_type(draw: Draw) -> Scene:
    """Thresholds that are times of a Markov chain: the force is a matrix exponential."""
    kind, rate = draw.whole(0, 4), 1.0 / draw.unit
    if kind == 0:
        stages = draw.whole(1, 7)
        chain = hyper_erlang([1.0], [stages], [rate * stages])
    elif kind == 1:
        share = draw.even(0.1, 0.9)
        rates = [rate * draw.log(0.3, 3.0), rate * draw.log(0.3, 3.0)]
        chain = hyper_erlang([share, 1.0 - share], [1, 1], rates)
    elif kind == 2:
        share = draw.even(0.1, 0.9)
        two = [draw.whole(1, 4), draw.whole(1, 4)]
        chain = hyper_erlang([share, 1.0 - share], two, [2.0 * rate, rate * draw.log(2.5, 8.0)])
    else:
        chain = coxian(rate * draw.log(0.3, 0.9), rate * draw.log(1.1, 4.0), draw.even(0.1, 1.0))
    start = [0.0, draw.even(0.0, 0.8), draw.even(-0.5, 0.0)][draw.whole(0, 3)] * chain.mean
    contacts = origins.Contacts(chain.law, start)
    path = draw.path(20.0, chain.mean)
    return Scene(contacts, path, draw.tolerance(), lambda x: chain.force(x, start))


def peak(draw: Draw, low: float, high: float, width: float) -> origins.Thresholds:
    """A Gaussian somewhere between low and high."""
    return origins.gaussian(
        draw.unit * draw.even(low, high), draw.unit * draw.log(width, 0.2, 1e-4, 0.2)
    )


def box(draw: Draw, low: tuple[float, float], width: tuple[float, ...]) -> origins.Thresholds:
    """Evenly spread thresholds."""
    first = draw.unit * draw.even(*low)
    return origins.rectangular(first, first + draw.unit * draw.log(*width))


def exact_and_box(draw: Draw) -> origins.Thresholds:
    """Two in five contacts share one exact threshold."""
    exact = origins.identical(draw.unit * draw.even(0.3, 1.5))
    return origins.mixture([exact, box(draw, (0.1, 1.0), (0.05, 1.0))], [0.4, 0.6])


def two_exact_and_peak(draw: Draw) -> origins.Thresholds:
    """Half of the contacts have one of two exact thresholds."""
    low, high = draw.unit * draw.even(0.3, 0.8), draw.unit * draw.even(0.8, 1.5)
    parts = [origins.identical(low), origins.identical(high)]
    return origins.mixture([*parts, origins.gaussian(draw.unit, 0.1 * draw.unit)], [0.2, 0.3, 0.5])


SMOOTH: list[Callable[[Draw], object]] = [
    lambda d: origins.gaussian(d.unit, d.unit * d.log(0.01, 1.0, 1e-4, 3.0)),
    lambda d: box(d, (0.0, 1.0), (0.1, 1.5, 1e-4, 1.5)),
    lambda d: origins.gw_elastic(d.log(0.1, 10.0) / d.unit ** (4.0 / 3.0)),
    lambda d: origins.gw_plastic(d.log(0.1, 10.0) / d.unit**2),
    lambda d: origins.persson(d.unit, d.unit * d.log(0.1, 5.0, 1e-3, 1e3)),
    lambda d: origins.lubricated(d.unit * d.log(0.3, 3.0)),
    lambda d: origins.mixture([peak(d, 0.2, 1.0, 0.02), peak(d, 1.0, 2.0, 0.02)], [0.3, 0.7]),
    lambda d: origins.mixture(
        [origins.rectangular(0.2 * d.unit, 0.4 * d.unit), peak(d, 0.8, 2.0, 0.02)], [0.3, 0.7]
    ),
]
LAWS: list[Callable[[Draw], object]] = [
    *SMOOTH,
    exact_and_box,
    two_exact_and_peak,
    lambda d: origins.from_samples(d.unit * d.rng.gamma(3.0, 1.0 / 3.0, size=200)),
    lambda d: scipy.stats.gamma(d.log(0.5, 8.0), scale=d.unit),
    lambda d: scipy.stats.lognorm(d.log(0.1, 1.0), scale=d.unit),
    lambda d: scipy.stats.lomax(d.log(2.2, 5.0, 2.1, 2.2), scale=d.unit),
    lambda d: scipy.stats.beta(d.even(1.0, 4.0), d.even(1.0, 4.0), scale=d.unit),
]


def thresholds(draw: Draw, laws: list[Callable[[Draw], object]]) -> origins.Thresholds:
    """One of the laws."""
    return origins.Contacts(laws[draw.whole(0, len(laws))](draw)).thresholds


def far_start(draw: Draw, law: origins.Thresholds) -> float:
    """Beyond most thresholds, on either side, and close below one that is the strongest of all."""
    at = float(law.isf(draw.log(1e-5, 1.0)))
    at *= 1.0 if law.sf(at) > 0.0 else 1.0 - 1e-3
    return [-at, at][draw.whole(0, 2)]


def single_start(draw: Draw, law: origins.Thresholds) -> object:
    """Relaxed, or all at one stretch."""
    if draw.far():
        return far_start(draw, law)
    low = float(law.ppf(0.1))
    return [None, draw.even(-0.5, 0.8) * low, draw.even(0.0, 0.5) * low][draw.whole(0, 3)]


def any_start(draw: Draw, law: origins.Thresholds) -> object:
    """At one stretch, or with a width."""
    low = float(law.ppf(0.1))
    wide = [
        origins.gaussian_start(draw.even(-0.2, 0.3) * low, draw.log(0.003, 0.05) * low),
        scipy.stats.uniform(draw.even(-0.3, 0.3) * low, 0.3 * low),
    ]
    return single_start(draw, law) if draw.rng.random() < 0.5 else wide[draw.whole(0, 2)]


def any_law(draw: Draw) -> Scene:
    """Contacts without laws of their own, forward."""
    law = thresholds(draw, LAWS)
    contacts = origins.Contacts(law, any_start(draw, law))
    return Scene(contacts, draw.path(20.0, law.mean()), draw.tolerance())


def turning(draw: Draw) -> Scene:
    """The same, turning round."""
    law = thresholds(draw, LAWS)
    contacts = origins.Contacts(law, any_start(draw, law))
    return Scene(contacts, draw.turns(law.mean()), draw.tolerance())


def forward(draw: Draw, start: bool = True, **laws: Any) -> Scene:
    """Contacts with laws of their own, forward at one speed."""
    law = thresholds(draw, LAWS if draw.far() else SMOOTH)
    contacts = origins.Contacts(law, single_start(draw, law) if start else None, **laws)
    path = draw.path(12.0, law.mean())
    return Scene(contacts, path, draw.tolerance(), drive={"velocity": draw.speed()})


def heat(draw: Draw, closure: str = "exact") -> origins.Thermal:
    """Soft or stiff contacts at an ordinary temperature."""
    law = ["soft", "stiff"][draw.whole(0, 2)]
    temperature = draw.unit**2 * draw.log(1e-3, 1.0, 1e-8, 1e3)
    return origins.Thermal(law, temperature, draw.log(0.03, 30.0, 1e-12, 1e12), closure)


def warm(draw: Draw) -> Scene:
    """With temperature."""
    return forward(draw, thermal=heat(draw))


def warm_wide_start(draw: Draw) -> Scene:
    """With temperature and a start with a width, or in the paper's closure."""
    if draw.rng.random() < 0.5:
        return forward(draw, thermal=heat(draw, "paper"))
    law = origins.gaussian(draw.unit, draw.unit * draw.log(0.05, 0.1))
    start = origins.gaussian_start(draw.unit * draw.even(0.0, 0.2), 0.02 * draw.unit)
    contacts = origins.Contacts(law, start, thermal=heat(draw))
    path = draw.path(12.0, draw.unit)
    return Scene(contacts, path, draw.tolerance(), drive={"velocity": draw.speed()})


def delayed(draw: Draw) -> Scene:
    """With a delay."""
    return forward(draw, delay=origins.Delay(draw.log(0.03, 2.0, 1e-6, 1e6)))


def linked(draw: Draw) -> Scene:
    """With stiffnesses that follow the thresholds."""
    return forward(draw, stiffness="linked")


def formed_again(draw: Draw) -> Scene:
    """Re-forming at one stretch or at many."""
    unit = draw.unit
    law = origins.gaussian(unit, unit * draw.log(0.02, 0.3, 1e-4, 1.0))
    again: object = unit * draw.even(-0.3, 0.3)
    if draw.rng.random() < 0.5:
        again = origins.boltzmann_reforming(unit**2 * draw.log(1e-4, 1e-2, 1e-8, 1e-2))
    elif draw.far():
        again = far_start(draw, law)
    contacts = origins.Contacts(law, single_start(draw, law), reforming=again)
    return Scene(contacts, draw.path(12.0, unit), draw.tolerance())


def all_at_once(draw: Draw) -> Scene:
    """Temperature, delay, re-forming and linked stiffness together."""
    unit, wait = draw.unit, origins.Delay(draw.log(0.03, 1.0, 1e-6, 1e6))
    law = origins.gaussian(unit, unit * draw.log(0.03, 0.3, 1e-4, 1.0))
    again = far_start(draw, law) if draw.far() else unit * draw.even(-0.2, 0.2)
    contacts = origins.Contacts(
        law,
        single_start(draw, law),
        thermal=heat(draw),
        delay=wait,
        reforming=again,
        stiffness="linked",
    )
    path = draw.path(12.0, unit)
    return Scene(contacts, path, draw.tolerance(), drive={"velocity": draw.speed()})


def old_and_young(draw: Draw) -> tuple[origins.Thresholds, origins.Ageing]:
    """Fresh thresholds, and what they become."""
    unit = draw.unit
    fresh = origins.gaussian(0.5 * unit, unit * draw.log(0.03, 0.1, 1e-3, 0.3))
    final = origins.gaussian(unit, unit * draw.log(0.02, 0.1, 1e-3, 0.3))
    return fresh, origins.Ageing(final, unit**2 * draw.log(1e-4, 1e-2, 1e-8, 1e4))


def ageing(draw: Draw) -> Scene:
    """Thresholds that diffuse, forward."""
    fresh, older = old_and_young(draw)
    path = draw.path(4.0, draw.unit)
    contacts = origins.Contacts(fresh, ageing=older)
    return Scene(contacts, path, draw.tolerance(1e-7), drive={"velocity": draw.unit})


def growing_grains(draw: Draw, far_in_time: bool = True) -> tuple[origins.Contacts, float]:
    """Grains that grow and wait until they are pinned, and a speed that suits them."""
    unit = draw.unit
    alpha, wide = draw.log(0.4, 2.5, 1e-3, 1e3), draw.log(0.05, 20.0, 1e-6, 1e6) / unit**2
    first = (2.0 / (3.0 * alpha)) ** 3
    age = first * (1.0 + draw.log(0.3, 50.0, 1e-5, 1e7))
    grains = origins.growing_grains(alpha, wide, age=age)
    mean = grains.at_start.mean()
    near = origins.gaussian_start(draw.even(-0.3, 0.5) * mean, 0.1 * mean)
    start = [None, draw.even(-0.5, 0.6) * mean, near][draw.whole(0, 3 if far_in_time else 2)]
    wait = origins.Delay(first * draw.log(0.1, 1.0, 1e-6, 1e6))
    speed = draw.log(0.15, 2.0, 1e-6, 1e3) / (first * wide**0.5)
    return origins.Contacts(grains, start, delay=wait), speed


def growing(draw: Draw) -> Scene:
    """Grains that grow, forward."""
    contacts, speed = growing_grains(draw)
    path = draw.path(8.0, contacts.mean_threshold)
    return Scene(contacts, path, draw.tolerance(), drive={"velocity": speed})


def older_in_time(draw: Draw) -> Scene:
    """Thresholds that diffuse, or grains that grow, on paths that turn and wait."""
    if draw.rng.random() < 0.5:
        fresh, older = old_and_young(draw)
        contacts = origins.Contacts(fresh, ageing=older)
        path, time = draw.journey(draw.unit, 1e3)
        return Scene(contacts, path, draw.tolerance(1e-4), drive={"time": time})
    contacts, speed = growing_grains(draw, far_in_time=False)
    path = draw.turns(contacts.mean_threshold)
    return Scene(contacts, path, draw.tolerance(1e-4), drive={"velocity": speed})


def in_time(draw: Draw, **laws: Any) -> Scene:
    """Turns, velocity steps and holds."""
    law = thresholds(draw, SMOOTH)
    path, time = draw.journey(law.mean())
    contacts = origins.Contacts(law, single_start(draw, law), **laws)
    return Scene(contacts, path, draw.tolerance(1e-7), drive={"time": time})


def warm_in_time(draw: Draw) -> Scene:
    """With temperature in both closures, now and then with a delay."""
    closure = "exact" if draw.rng.random() < 0.7 else "paper"
    soft = closure == "paper" or draw.rng.random() < 0.8
    temperature, attempts = draw.log(0.03, 1.0, 1e-7, 1e-3), draw.log(0.03, 30.0, 1e-3, 1e15)
    if temperature > 1e-3 and closure == "exact":
        attempts = min(attempts, 30.0)  # or they break a billion times
    name = "soft" if soft else "stiff"
    thermal = origins.Thermal(name, temperature * draw.unit**2, attempts, closure)
    wait = origins.Delay(draw.log(0.3, 1.5)) if draw.rng.random() < 0.2 else None
    return in_time(draw, thermal=thermal, delay=wait)


def cold_in_time(draw: Draw) -> Scene:
    """Delay, linked stiffness or re-forming."""
    kind = draw.whole(0, 3)
    if kind == 0:
        return in_time(draw, delay=origins.Delay(draw.log(0.3, 2.0)))
    if kind == 1:
        return in_time(draw, stiffness="linked")
    return in_time(draw, reforming=draw.unit * draw.even(-0.05, 0.05))


def pulled(draw: Draw, finest: float = 1e-8, **laws: Any) -> Scene:
    """A soft slider, by each slip rule."""
    law = thresholds(draw, SMOOTH)
    slip = ["reset", "reform-after", "instant"][draw.whole(0, 2 if laws else 3)]
    contacts = origins.Contacts(law, **laws)
    end = draw.even(2.0, 4.0 if laws else 10.0) * law.mean()
    path = draw.rng.uniform(0.0, end, draw.whole(2, POINTS)).cumsum()
    path *= end / path[-1]
    drive = {"spring": draw.log(0.05, 3.0), "slip": slip, "velocity": draw.speed()}
    return Scene(contacts, path, draw.tolerance(finest), drive=drive)


def pulled_with_laws(draw: Draw) -> Scene:
    """A soft slider on contacts with temperature or a delay."""
    if draw.rng.random() < 0.5:
        return pulled(draw, 1e-4, delay=origins.Delay(draw.log(0.03, 1.0)))
    temperature = draw.unit**2 * draw.log(1e-3, 0.05)
    return pulled(draw, 1e-4, thermal=origins.Thermal("soft", temperature, draw.log(0.03, 3.0)))


COLD = [narrow_gaussian, phase_type, any_law, turning, delayed, linked, formed_again, pulled]
WARM = [warm, warm_wide_start, all_at_once, ageing, growing]
ON_PATHS = [cold_in_time, warm_in_time, older_in_time, pulled_with_laws]
KINDS = [*COLD, *WARM, *ON_PATHS]

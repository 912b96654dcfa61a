"""Ordinary cases drawn at random over laws, starts and drives, each with the best second road to its answer."""

import contextlib
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
import scipy.stats

import origins
from origins.contacts import Contacts
from origins.errors import InputError
from origins.thresholds.law import Array
from toolkit.stability import truths
from toolkit.stability.case import LONGEST, ROUND_OFF, Case, Truth, simulated
from toolkit.stability.cohorts import by_cohorts
from toolkit.stability.drawn_laws import heat, narrow, rough, smooth
from toolkit.stability.heavy import by_equation_of_motion, by_steps
from toolkit.stability.renewal import COARSEST, by_renewal
from toolkit.stability.work import within_work

_POINTS = 33  # of a path
_FINER, _FINER_IN_TIME = 1e-2, 0.1  # of the tolerance, for the master equation as its own reference
_NEAR = 1e-11  # mean thresholds: a truth as good as that is taken, whatever the tolerance
BREAKS = 1e9  # of the ensemble where no other road is: F to some 1e-4 mean thresholds
_UNKNOWN = Truth(0.0, np.inf, "")
_UNITS = (-9.0, 3.0)  # decades of a mean threshold, such as nanometres in m


def drawn(seed: int, number: int) -> Case:
    """Ordinary case `number` of a seed: of each kind in turn, whatever the other numbers are."""
    rng = np.random.default_rng([seed, number])
    kind = list(KINDS)[number % len(KINDS)]
    return KINDS[kind](kind, f"{seed}.{number}", rng)


def _unit(rng: np.random.Generator) -> float:
    return float(10.0 ** rng.uniform(*_UNITS))


def _forward(rng: np.random.Generator) -> Array:
    """A path in mean thresholds, of even steps from 0."""
    return np.linspace(0.0, rng.uniform(1.5, 6.0), _POINTS)


def _turning(rng: np.random.Generator, longest: float = 2.5) -> Array:
    """A path in mean thresholds that turns round twice, within or beyond the first breaks."""
    corners = np.append(0.0, np.cumsum(rng.uniform(0.3, longest, 3) * [1.0, -1.0, 1.0]))
    return np.interp(np.linspace(0.0, 3.0, _POINTS), np.arange(4.0), corners)


def _digits(rng: np.random.Generator, least: float) -> float:
    """A tolerance between 1e-3 and `least`."""
    return float(10.0 ** rng.uniform(math.log10(least), -3.0))


def _start(rng: np.random.Generator, mean: float) -> float | None:
    return None if rng.random() < 0.4 else float(rng.uniform(0.0, 0.4)) * mean


def _gaussian(kind: str, name: str, rng: np.random.Generator) -> Case:
    unit = _unit(rng)
    start = origins.gaussian_start(*(rng.uniform([-0.1, 0.001], [0.2, 0.04]) * unit))
    contacts = Contacts(narrow(rng, unit), start if rng.random() < 0.5 else _start(rng, unit))
    return _case(kind, name, contacts, _forward(rng), truths.gaussian, _digits(rng, 1e-10))


def _renewed(kind: str, name: str, rng: np.random.Generator) -> Case:
    """Smooth laws on a forward path with the laws that the kind names."""
    law, path = smooth(rng, _unit(rng)), _forward(rng)
    mean = Contacts(law).mean_threshold
    laws: dict[str, Any] = {"start": _start(rng, mean)}
    if "delay" in kind:
        step = path[-1] * mean / COARSEST
        laws["delay"] = origins.Delay(step * float(rng.integers(1, COARSEST // 4)))
    if "heat" in kind:
        laws["thermal"] = heat(rng, mean)
    if "linked" in kind:
        laws["stiffness"] = "linked"
    tolerance = _digits(rng, 1e-7 if "heat" in kind else 1e-9)
    return _case(kind, name, Contacts(law, **laws), path, by_renewal, tolerance)


def _rough(kind: str, name: str, rng: np.random.Generator) -> Case:
    unit, reforming = _unit(rng), None
    law = smooth(rng, unit) if "re-forming" in kind else rough(rng, unit)
    path = _turning(rng) if "turning" in kind else _forward(rng)
    mean = Contacts(law).mean_threshold
    start: Any = _start(rng, mean)
    if rng.random() < 0.3:
        start = scipy.stats.uniform(-0.05 * mean, rng.uniform(0.01, 0.2) * mean)
    if "re-forming" in kind:
        reforming = origins.boltzmann_reforming(1e-3 * mean**2)
    contacts = Contacts(law, start, reforming=reforming)
    return _case(kind, name, contacts, path, None, _digits(rng, 1e-6))


def _in_time(kind: str, name: str, rng: np.random.Generator) -> Case:
    """Heat or a delay on a path that turns round and rests."""
    law, path = smooth(rng, _unit(rng)), _turning(rng, 1.0)
    mean = Contacts(law).mean_threshold
    laws: dict[str, Any] = {"delay": origins.Delay(float(rng.uniform(0.05, 1.0)) * mean)}
    laws = {"thermal": heat(rng, mean, ("soft",))} if "heat" in kind else laws
    time = np.append(0.0, np.cumsum(np.abs(np.diff(path)) + rng.uniform(0.0, 0.05, path.size - 1)))
    return _case(kind, name, Contacts(law, **laws), path, None, 1e-3, {"time": time * mean})


def _ageing(kind: str, name: str, rng: np.random.Generator) -> Case:
    unit, path = _unit(rng), _forward(rng)
    young, old = (origins.gaussian(at * unit, 0.05 * unit) for at in (0.5, rng.uniform(0.6, 1.0)))
    ageing = origins.Ageing(old, 10.0 ** rng.uniform(-4.0, -2.0) * unit)
    return _case(kind, name, Contacts(young, ageing=ageing), path, by_renewal, _digits(rng, 1e-5))


def _growing(kind: str, name: str, rng: np.random.Generator) -> Case:
    alpha = float(rng.uniform(0.3, 2.0))
    age = float(rng.uniform(1.2, 2.0)) * (2.0 / (3.0 * alpha)) ** 3
    law = origins.growing_grains(alpha=alpha, B=float(rng.uniform(0.5, 2.0)), age=age)
    return _case(kind, name, Contacts(law), _forward(rng), None, _digits(rng, 1e-6))


def _pulled(kind: str, name: str, rng: np.random.Generator) -> Case:
    """Relaxed Gaussian thresholds on a spring, under the rule for which F on the spring is F of the rigid slider."""
    unit, spring = _unit(rng), float(10.0 ** rng.uniform(-1.0, 1.5))
    contacts, path = Contacts(narrow(rng, unit)), _forward(rng)
    path = path * (1.0 + 0.5 / spring)
    truth = partial(truths.pulled, spring)
    drive = {"spring": spring, "slip": "instant"}
    return _case(kind, name, contacts, path, truth, _digits(rng, 1e-8), drive)


def _strengthening(kind: str, name: str, rng: np.random.Generator) -> Case:
    """Thresholds that grow with the logarithm of the age, from young to old contacts at the start; in time the path
    turns round and rests, and some contacts wait."""
    law, path = smooth(rng, _unit(rng)), _forward(rng)
    mean, drive, laws = Contacts(law).mean_threshold, dict[str, Any](), dict[str, Any]()
    if "in time" in kind:
        path = _turning(rng, 1.0)
        rests = rng.uniform(0.0, 0.3, path.size - 1) * (rng.random(path.size - 1) < 0.3)
        drive["time"] = np.append(0.0, np.cumsum(np.abs(np.diff(path)) + 0.01 + rests)) * mean
        if rng.random() < 0.4:
            laws["delay"] = origins.Delay(float(rng.uniform(0.05, 1.0)) * mean)
    beta, time, age = 10.0 ** rng.uniform([-2.5, -2.0, -3.0], [-0.5, 0.5, 1.0])
    grown = origins.strengthening(law, beta, time * mean, age * mean * rng.integers(2))
    contacts = Contacts(grown, _start(rng, mean), **laws)
    return _case(kind, name, contacts, path, None, _digits(rng, 1e-5), drive)


def _heavy(kind: str, name: str, rng: np.random.Generator) -> Case:
    """A slider with mass, from one that swings for long to one that is all but stopped, on contacts without laws, or
    with a delay or strengthening."""
    law: Any = narrow(rng, _unit(rng))
    mean, laws = Contacts(law).mean_threshold, dict[str, Any]()
    if "delay" in kind:
        law, laws["delay"] = smooth(rng, mean), origins.Delay(10.0 ** rng.uniform(-1.5, 0.3) * mean)
    if "strengthening" in kind:
        law = origins.strengthening(smooth(rng, mean), 10.0 ** rng.uniform(-2.5, -1.0), mean)
    contacts = Contacts(law, _start(rng, mean), **laws)
    spring, square = 10.0 ** rng.uniform([-1.0, -2.5], [1.0, 1.0])
    mass, part = (
        square * contacts.mean_threshold**2,
        rng.choice([0.0, 10.0 ** rng.uniform(-1.0, 0.5)]),
    )
    drive = {"spring": spring, "mass": mass, "damping": 2.0 * part * math.sqrt(spring * mass)}
    begin = contacts.start.mean() / spring / contacts.mean_threshold
    path = begin + np.linspace(0.1, rng.uniform(1.2, 2.5) * (1.0 + 0.7 / spring), _POINTS)
    tolerance = _digits(rng, 1e-3 if "strengthening" in kind else 1e-7)
    return _case(kind, name, contacts, path, None, tolerance, drive)


KINDS: dict[str, Callable[[str, str, np.random.Generator], Case]] = {
    "gaussian": _gaussian,
    "smooth law": _renewed,
    "delay": _renewed,
    "linked": _renewed,
    "heat": _renewed,
    "heat, delay": _renewed,
    "rough law": _rough,
    "re-forming": _rough,
    "turning": _rough,
    "delay in time": _in_time,
    "heat in time": _in_time,
    "ageing": _ageing,
    "growing grains": _growing,
    "spring": _pulled,
    "strengthening": _strengthening,
    "strengthening in time": _strengthening,
    "mass": _heavy,
    "mass, delay": _heavy,
    "mass, strengthening": _heavy,
}


def _case(
    kind: str,
    name: str,
    contacts: Contacts,
    path: Array,
    road: Callable[[Contacts, Array], Truth] | None,
    tolerance: float,
    drive: Mapping[str, Any] | None = None,
) -> Case:
    """The case, whose truth is found once: by the road where that is good enough, else by `finer` where the road bears
    it out; where it does not, the road is the truth, so that a fault of both answers of the master equation is seen."""
    kept, drive = list[Truth](), drive or {}
    roads = [road] if road else []
    if "mass" in drive:
        roads = [partial(heavy, drive=drive) for heavy in (by_equation_of_motion, by_steps)]
    elif "spring" not in drive:
        roads.append(partial(by_cohorts, time=drive.get("time")))
        roads.append(partial(by_ensemble, drive=drive))

    def found_once(contacts: Contacts, path: Array) -> Truth:
        if not kept:
            truth = next(_taken(roads, contacts, path), _UNKNOWN)
            if np.min(truth.error) > max(1e-3 * tolerance, _NEAR):
                truth = _borne_out(finer(contacts, path, tolerance, drive), truth)
            kept.append(truth)
        return kept[0]

    return Case(kind, name, lambda: contacts, path, found_once, drive, tolerance, n_contacts=0)


def _taken(
    roads: Sequence[Callable[[Contacts, Array], Truth]], contacts: Contacts, path: Array
) -> Iterator[Truth]:
    """What those roads say that take the contacts."""
    for road in roads:
        with contextlib.suppress(InputError):
            yield road(contacts, path)


def _borne_out(fine: Truth, beside: Truth) -> Truth:
    """The finer of two truths, unless they contradict each other, or it is unknown somewhere: then the other one."""
    if not np.isfinite(beside.error).all():
        return fine
    apart = np.abs(fine.values - beside.values) - fine.error - beside.error
    if not np.isfinite(fine.error).all() or (apart > ROUND_OFF).any():
        return beside
    return Truth(fine.values, fine.error, f"{fine.road}, beside {beside.road}")


def by_ensemble(contacts: Contacts, path: Array, drive: Mapping[str, Any]) -> Truth:
    """The other solver, with as many contacts as break so many times on the path."""
    unit = contacts.mean_threshold
    lives = max(float(np.abs(np.diff(path, prepend=0.0)).sum()) / unit, 1.0)
    case = Case("", "", lambda: contacts, path / unit, drive=drive, n_contacts=int(BREAKS / lives))
    found = simulated(case, contacts, path, longest=100.0 * LONGEST)  # it takes some 10 CPU-s
    return Truth(found.values, float(np.max(found.error)), f"the ensemble at {BREAKS:.0e} breaks")


def finer(contacts: Contacts, path: Array, tolerance: float, drive: Mapping[str, Any]) -> Truth:
    """The master equation at a tighter tolerance: no road of its own."""
    import master

    tighter = tolerance * (_FINER_IN_TIME if "time" in drive else _FINER)
    force, error = np.zeros(path.size), np.full(path.size, np.inf)
    road = "the master equation at a tighter tolerance"
    try:
        found = within_work(partial(master.solve, contacts, path, tighter, **drive), LONGEST)
    except InputError:
        return Truth(force, error, road)
    there = found.force.size  # a path may be cut
    force[:there] = found.force / contacts.mean_threshold
    error[:there] = found.force_error
    return Truth(force, error, road)

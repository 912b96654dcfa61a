"""Do error bars hold? Many drawn cases: how often the claim bounds the true error, and how often sigmas hold it."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import special

from origins.thresholds.law import Array
from toolkit.stability import truths
from toolkit.stability.case import (
    OVERRUN,
    ROUND_OFF,
    SIGMAS,
    Case,
    CaseAnswer,
    Question,
    Row,
    Truth,
    bounding_factor,
)
from toolkit.stability.drawn import drawn
from toolkit.stability.table import answered

PROMISED = 0.99  # of the cases have an error within the claim
EXPECTED = (0.6827, 0.9545, 0.9973)  # of normal errors lie within 1, 2, 3 standard errors
_COUNTED = 3.0  # counting errors that a fraction may be off by
_CONTACTS = 4_000  # of the ensemble in a case
# on a spring: so many that their mean is that of infinitely many, to a part of the scatter of the replicas
_COUPLED, _REPLICAS = 100_000, 16
_FEWEST = 30  # broken contacts, of a replica, without which errors are not normal
# of an error by chance that the truth may be off by
_SURE = 0.1
_SLIPS = 0.01  # mean thresholds of K X_T, 10 times what F scatters by: so near a slip some replicas have slipped


@dataclass(frozen=True)
class CountedFraction:
    """How many of `all` cases `hold`."""

    hold: int
    all: int

    @property
    def value(self) -> float:
        return self.hold / max(self.all, 1)

    def counting_error(self, expected: float) -> float:
        """Standard error of the fraction where `expected` is true."""
        return float(np.sqrt(expected * (1.0 - expected) / max(self.all, 1)))


@dataclass(frozen=True)
class Coverage:
    """What the rows of many cases tell.

    bounded : cases in which the master equation's claim bounds the true error; those that are refused, cut or
        unknown do not
    ratios : claim over true error (or round-off) where the truth is known well enough to tell, (n,)
    overruns : claims of success beside an error above 3 tolerances
    within : cases of the ensemble whose error is at most 1, 2 and 3 standard errors
    """

    bounded: CountedFraction
    ratios: Any
    overruns: int
    within: tuple[CountedFraction, ...]

    @property
    def promise_kept(self) -> bool:
        """Whether claims hold, in as many cases as chance lets so few tell."""
        missing = self.bounded.all * (1.0 - PROMISED)
        return self.bounded.all - self.bounded.hold <= missing and not self.overruns

    @property
    def sigmas_kept(self) -> bool:
        """Whether intervals hold what they should, within counting error."""
        return all(
            abs(fraction.value - expected) <= _COUNTED * fraction.counting_error(expected)
            for fraction, expected in zip(self.within, EXPECTED, strict=True)
        )


def ask(cases: int, seed: int, found: list[Row], count: Callable[[int, int], None]) -> None:
    """Add the rows of so many drawn cases to `found`; `count` is told how many are done, and of how many.

    The master equation is held over the path, the ensemble at one of its points, so that each of its rows is an error
    by itself. Where few contacts have broken the ensemble has none.
    """
    for number in range(cases):
        case = drawn(seed, number)
        found += answered(case)
        found += answered(_ensemble(case, seed + number))
        count(number + 1, cases)


def _ensemble(case: Case, seed: int) -> Question:
    """The ensemble's force at a point of the case's path, drawn among those where enough contacts have broken."""
    import eq_model

    contacts, place = case.contacts(), list[int]()
    unit = contacts.mean_threshold
    path, drive = case.path * unit, case.drive
    many: dict[str, Any] = {"n_contacts": _CONTACTS, "n_replicas": 1, "seed": seed}
    if "spring" in drive:
        many |= {"n_contacts": _COUPLED, "n_replicas": _REPLICAS}

    def whole() -> Truth:
        found = case.truth(contacts, path) if case.truth else None
        assert found is not None
        return found

    def ask_it() -> CaseAnswer:
        found: Any = eq_model.simulate(contacts, path, **many, **drive)
        error = found.force_standard_error / unit
        if "spring" in drive:
            enough = _tells_on_spring(case, whole(), error)
        else:
            enough = error > np.sqrt(_FEWEST) / _CONTACTS
        tell = np.flatnonzero(enough)
        if not tell.size:
            return CaseAnswer(np.empty(0), np.inf, False, None, "too few contacts broke to tell")
        at = int(np.random.default_rng(seed).choice(tell))
        place.append(at)
        bound = _factor(case.group) * error[at] + found.step_error[at] / unit
        return CaseAnswer(found.force[at] / unit, bound, bool(found.success), None, found.message)

    def truth() -> Truth:
        along, at = whole(), place or [0]
        error = np.broadcast_to(along.error, along.values.shape)
        return Truth(along.values[at], error[at], along.road)

    return Question(case.group, case.name, "ensemble", ask_it, truth)


def _tells_on_spring(case: Case, truth: Truth, error: Array) -> Array:
    """At which points replicas have scattered enough, about a force that is known far better; without a mass none near
    slips, to which some replicas come before the point and some after it."""
    contacts, spring = case.contacts(), case.drive["spring"]
    broken = np.sqrt(_FEWEST / _REPLICAS) / _COUPLED * spring / (1.0 + spring)
    enough = (error > broken) & (truth.error < _SURE * error)
    if "mass" in case.drive:
        return np.asarray(enough)
    path = case.path * contacts.mean_threshold
    apart = truths.pulled(spring, contacts, path, _SLIPS)
    return np.asarray(enough & np.isfinite(apart.error))


def _is_coupled(group: str) -> bool:
    return "spring" in group or "mass" in group


def _factor(group: str) -> float:
    """Standard errors that bound the ensemble."""
    return bounding_factor(_REPLICAS) if _is_coupled(group) else SIGMAS


def _sigmas(row: Row) -> float:
    """By how many standard errors the ensemble is off, of normal errors: of few replicas by Student's t."""
    off = _factor(row.group) * row.error / row.claim
    if not _is_coupled(row.group):
        return off
    return float(-special.ndtri(special.stdtr(_REPLICAS - 1, -off)))


def coverage(rows: Iterable[Row]) -> Coverage:
    """What these rows tell."""
    by_master = [row for row in rows if row.solver != "ensemble"]
    bounded = sum(not _failed(row) for row in by_master)
    sure = [row for row in by_master if row.floor <= 0.3 * max(row.claim, row.error)]
    ratios = [row.claim / max(row.error, ROUND_OFF) for row in sure]
    overruns = sum(row.said == OVERRUN for row in by_master)
    by_ensemble = [row for row in rows if row.solver == "ensemble"]
    sampled = [row for row in by_ensemble if np.isfinite([row.error, row.floor]).all()]
    off = np.array([_sigmas(row) for row in sampled])
    within = tuple(
        CountedFraction(int((off <= sigma).sum()), off.size) for sigma in (1.0, 2.0, 3.0)
    )
    return Coverage(CountedFraction(bounded, len(by_master)), np.array(ratios), overruns, within)


def _failed(row: Row) -> bool:
    """Whether there is no answer, or too little is claimed, or of the master equation nothing."""
    unknown = row.solver != "ensemble" and not np.isfinite([row.error, row.claim]).all()
    return row.verdict in ("wrong", "refused") or unknown


def as_lines(rows: Sequence[Row]) -> list[str]:
    """In words what the rows tell: a line for each kind of case, one for all of them, the cases that failed, and
    whether the promises are kept."""
    head = ("kind", "cases", "held", "claim/error", "1σ %", "2σ %", "3σ %", "held against")
    lines = [_line(head)]
    for kind in [*dict.fromkeys(row.group for row in rows), "all"]:
        own = [row for row in rows if kind in (row.group, "all")]
        found, roads = coverage(own), sorted({row.road for row in own if row.road})
        ratio = f"{np.median(found.ratios):.3g}" if found.ratios.size else ""
        sigmas = [f"{100.0 * one.value:.1f}" if one.all else "" for one in found.within]
        against = "" if kind == "all" else "; ".join(roads)
        lines.append(_line((kind, found.bounded.all, found.bounded.hold, ratio, *sigmas, against)))
    lines += [
        f"{row.verdict}: {row.solver}, {row.group} {row.case}: {row.said}"
        for row in rows
        if _failed(row)
    ]
    found = coverage(rows)
    bounded, sure = found.bounded, found.ratios.size
    missed = [row.verdict for row in rows if row.solver != "ensemble" and _failed(row)]
    refused, wrong = missed.count("refused"), missed.count("wrong")
    lines.append(
        f"master: its claim bounds the true error in {bounded.hold} of {bounded.all} cases, "
        f"{100.0 * bounded.value:.1f} %, at least 99 % promised; "
        f"{refused} refused, {len(missed) - refused - wrong} cut or not known, and {wrong} that "
        f"claim too little count against it. Half of its claims are within "
        f"{np.median(found.ratios) if sure else np.nan:.3g} times the true error, or round-off ({sure} cases tell)"
    )
    for sigma, (fraction, expected) in enumerate(zip(found.within, EXPECTED, strict=True), start=1):
        if not fraction.all:
            continue
        error = 100.0 * fraction.counting_error(expected)
        lines.append(
            f"ensemble: {100.0 * fraction.value:.1f} % of {fraction.all} errors within {sigma} standard errors; "
            f"{100.0 * expected:.1f} ± {error:.1f} by chance"
        )
    return lines


def _line(cells: Sequence[Any]) -> str:
    kind, cases, holding, ratio, *sigmas, against = cells
    within = "".join(f"{percent:>7}" for percent in sigmas)
    return f"{kind:16}{cases:>6}{holding:>6}{ratio:>13}{within}  {against}"


def plain_coverage(found: Coverage) -> dict[str, Any]:
    """The fractions for JSON; `promise_kept` and `sigmas_kept` are the judgement."""
    ratio = float(np.median(found.ratios)) if found.ratios.size else None
    return {
        "held": found.bounded.hold,
        "master_cases": found.bounded.all,
        "median_claim_over_error": ratio,
        "overruns": found.overruns,
        "within_sigmas": [fraction.value for fraction in found.within],
        "ensemble_cases": found.within[0].all,
        "promise_kept": found.promise_kept,
        "sigmas_kept": found.sigmas_kept,
    }

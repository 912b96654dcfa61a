"""One extreme case, what is asked of it, and the verdict on what a solver answers."""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Literal

import numpy as np
from scipy import special

from origins.contacts import Contacts
from origins.errors import InputError, NothingInTimeError
from origins.thresholds.law import Array
from toolkit.stability.work import OUT_OF_TIME, within_work

Verdict = Literal["exact", "within tolerance", "short, and says so", "slow", "refused", "wrong"]
ROUND_OFF = 1e-13  # mean thresholds: an answer nearer to the truth is exact
# the ensemble follows positions in whole units of about this part of the path (eq_model/whole_drive.py): no error by
# chance, so that contacts which all do the same have it beside a standard error of 0
IN_UNITS = 2.0**-44
UNSEEN = 10.0  # breaks that may be expected where none was seen, which has a probability of 5e-5 then, and no scatter
WITNESSES = {"master": "the master equation", "ensemble": "the ensemble"}
REPLICAS = 24  # of soft sliders, whose contacts are coupled
SIGMAS = 5.0  # standard errors that bound the ensemble: chance passes them once in two million
LONGEST = 10.0  # CPU-s for a solver and a case; it then gives what it has, and says so
GRANTED = 3.0  # tolerances by which an answer that claims success may be off, as docs promise
OVERRUN = "claims success beside a larger error than its tolerance"


@dataclass(frozen=True)
class Truth:
    """What holds, by a road of its own.

    values : (n,), of a `Case` forces in mean thresholds, of a `Question` its number in the unit of its name
    error : bound of the error of these values, a number or (n,)
    road : which road it is, in words
    """

    values: Any
    error: Any
    road: str


@dataclass(frozen=True)
class CaseAnswer:
    """What the toolkit says.

    values : (n,); error : a bound of their error, a number or (n,)
    success : whether it claims to have reached its `tolerance`, None where it has none
    message : what it says of that; faults : invariants that do not hold, in words
    """

    values: Any
    error: Any
    success: bool = True
    tolerance: float | None = None
    message: str = ""
    faults: tuple[str, ...] = ()


@dataclass(frozen=True)
class Row:
    """A line of the table.

    error : largest difference from the truth, in mean thresholds (or the unit of the case's name); nan where refused,
        or where invariants alone are known
    floor : what the truth itself is good for there, below which `error` says nothing
    claim : what the solver says of its error there; run_time : in CPU-s
    road : of the truth; said : the solver's message
    """

    group: str
    case: str
    solver: str
    verdict: Verdict
    error: float
    floor: float
    claim: float
    run_time: float
    road: str
    said: str


@dataclass(frozen=True)
class Case:
    """Contacts on a path.

    contacts : makes them, in any unit of length, so that a refusal is a row of the table
    path : positions (n,), in mean thresholds
    truth : of the forces in mean thresholds, by a road of its own; None where only the other solver knows
    drive : keywords of both solvers, in the contacts' unit
    tolerance : of the master equation
    n_contacts : of the ensemble; 0 leaves it out
    of_ensemble : other keywords of it, such as n_replicas
    """

    group: str
    name: str
    contacts: Callable[[], Contacts]
    path: Any
    truth: Callable[[Contacts, Array], Truth] | None = None
    drive: Mapping[str, Any] = field(default_factory=dict)
    tolerance: float = 1e-6
    n_contacts: int = 100_000
    of_ensemble: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Question:
    """A number (K*, F_k, <x_s> of an origin, the regime) with its truth; `solver`: who answers, in the table."""

    group: str
    name: str
    solver: str
    ask: Callable[[], CaseAnswer]
    truth: Callable[[], Truth]


@dataclass(frozen=True)
class Judgement:
    """The verdict on an answer, with the numbers of a `Row`."""

    verdict: Verdict
    error: float
    floor: float
    claim: float
    said: str


def judged(answer: CaseAnswer, truth: Truth) -> Judgement:
    """The verdict on an answer, with the numbers at its largest error, or where that is farthest beyond the claim.

    Wrong is: an error above the claim and the truth's own error together, a claim of success beside an error above
    `GRANTED` tolerances, an invariant that does not hold, or a value that is no number beside a claim that is one.
    """
    values, expected = np.atleast_1d(answer.values), np.atleast_1d(truth.values)
    claims = np.broadcast_to(np.asarray(answer.error, float), values.shape)
    floors = np.broadcast_to(np.asarray(truth.error, float), expected.shape)
    if not values.size:
        return Judgement(_short(answer), np.nan, np.nan, np.inf, answer.message)
    both, cut = min(values.size, expected.size), values.size < expected.size  # a path may be cut
    values, claims = values[:both], claims[:both]
    expected, floors = expected[:both], floors[:both]
    off = np.abs(np.subtract(values, expected, out=np.zeros(both), where=values != expected))
    if (unknown := ~np.isfinite(off)).any():
        honest = not answer.success and np.isinf(claims[unknown]).all()
        verdict: Verdict = _short(answer) if honest else "wrong"
        return Judgement(verdict, np.nan, np.nan, np.inf, answer.message or "no number")
    checked = np.isfinite(floors)
    off = np.where(checked, off, 0.0)  # elsewhere the truth says nothing
    worst = int(np.argmax(np.where(checked, off, -1.0)))
    beyond = off - floors - ROUND_OFF
    said = answer.message
    if answer.faults:
        verdict, said = "wrong", "; ".join(answer.faults)
    elif answer.success and answer.tolerance and (beyond > GRANTED * answer.tolerance).any():
        verdict, said = "wrong", OVERRUN
    elif (beyond > claims).any():
        worst = int(np.argmax(beyond - claims))
        verdict, said = "wrong", "off by more than it claims"
    elif not answer.success or cut:
        verdict = _short(answer)
    else:
        exact = checked.any() and off.max() <= ROUND_OFF
        verdict = "exact" if exact else "within tolerance"
    claim = np.inf if cut else float(claims[worst])  # of the rest of a path nothing is known
    error = float(off[worst]) if checked[worst] else np.nan
    return Judgement(verdict, error, float(floors[worst]), claim, said)


def _short(answer: CaseAnswer) -> Verdict:
    """An answer that lacks something must say so; where it was cut for want of time it is slow."""
    if answer.success:
        return "wrong"
    slow = any(words in answer.message for words in OUT_OF_TIME)
    return "slow" if slow else "short, and says so"


def rows(case: Case | Question) -> list[Row]:
    """The rows of a case: one for each solver, each against the case's truth, or else the other solver."""
    if isinstance(case, Question):
        found = _timed(case.ask)
        return [_row(case, case.solver, found, None if isinstance(found[0], str) else case.truth())]
    try:
        contacts = case.contacts()
    except InputError as refusal:
        return [_row(case, "origins", (str(refusal), 0.0), None)]
    path = np.asarray(case.path, float) * contacts.mean_threshold
    asked = {"master": solved} | ({"ensemble": simulated} if case.n_contacts else {})
    laws = (contacts.thermal, contacts.ageing)
    if any(getattr(law, "closure", "exact") == "paper" for law in laws):
        asked.pop("ensemble", None)  # single contacts do not follow the paper's closures
    answers = {name: _timed(partial(ask, case, contacts, path)) for name, ask in asked.items()}
    truth = None if case.truth is None else case.truth(contacts, path)
    out = list[Row]()
    for name, found in answers.items():
        other = "ensemble" if name == "master" else "master"
        witness = _witness(other, answers.get(other, ("", 0.0))[0])
        out.append(_row(case, name, found, truth or witness or _no_witness(found[0])))
    return out


def _timed(ask: Callable[[], CaseAnswer]) -> tuple[CaseAnswer | str, float]:
    """An answer, or the text of its refusal, and its CPU time in s, as a busy machine takes longer by the clock."""
    began = time.process_time()
    try:
        answer: CaseAnswer | str = ask()
    except NothingInTimeError as over:
        answer = CaseAnswer(np.empty(0), np.inf, False, None, str(over))
    except InputError as refusal:
        answer = str(refusal)
    return answer, time.process_time() - began


def _row(
    case: Case | Question, solver: str, found: tuple[CaseAnswer | str, float], truth: Truth | None
) -> Row:
    answer, took = found
    if isinstance(answer, str) or truth is None:
        nothing = (np.nan, np.nan, np.nan)
        return Row(case.group, case.name, solver, "refused", *nothing, took, "", str(answer))
    one = judged(answer, truth)
    return Row(
        *(case.group, case.name, solver, one.verdict, one.error, one.floor, one.claim, took),
        *(truth.road, one.said),
    )


def _witness(name: str, answer: CaseAnswer | str) -> Truth | None:
    """What the other solver says, if it says anything; where its path is cut nothing is known of the rest."""
    if isinstance(answer, str) or not answer.values.size or not np.isfinite(answer.error).all():
        return None
    return Truth(answer.values, answer.error, WITNESSES[name])


def _no_witness(answer: CaseAnswer | str) -> Truth | None:
    """No second road: invariants alone are checked."""
    return None if isinstance(answer, str) else Truth(answer.values, np.inf, "invariants alone")


def solved(case: Case, contacts: Contacts, path: Array) -> CaseAnswer:
    """The master equation's forces, in mean thresholds."""
    import master

    solve = partial(master.solve, contacts, path, case.tolerance, **case.drive)
    found = within_work(solve, LONGEST)
    unit, pulled = contacts.mean_threshold, _bounded(case, found.force)
    error, success = float(found.force_error), bool(found.success)
    faults = invariants(found.holding, pulled / unit, error, contacts, path)
    return CaseAnswer(found.force / unit, error, success, case.tolerance, found.message, faults)


def simulated(case: Case, contacts: Contacts, path: Array, longest: float = LONGEST) -> CaseAnswer:
    """The ensemble's forces, in mean thresholds; of soft sliders from so many replicas that their scatter is known."""
    import eq_model

    coupled = "spring" in case.drive
    many = {"n_replicas": REPLICAS if coupled else 1, "seed": 1} | dict(case.of_ensemble)
    simulate = partial(eq_model.simulate, contacts, path, n_contacts=case.n_contacts, **many)
    found = within_work(partial(simulate, **case.drive), longest)
    # of a slow one so many as are done; independent contacts tell their scatter by themselves
    replicas = found.contacts // case.n_contacts if coupled else 1
    unit, pulled = contacts.mean_threshold, _bounded(case, found.force)
    by_chance = bounding_factor(replicas or 1) * found.force_standard_error
    # a break takes the force of one contact, which is stretched by no more than the way, and by <x_s> as a rule
    stretch = np.minimum(np.maximum.accumulate(np.abs(path)), unit)
    unseen = UNSEEN / found.contacts * stretch
    error = (by_chance + unseen + found.step_error + IN_UNITS * np.abs(path).max()) / unit
    faults = invariants(found.holding, pulled / unit, 0.0, contacts, path)
    return CaseAnswer(found.force / unit, error, bool(found.success), None, found.message, faults)


def _bounded(case: Case, force: Array) -> Array:
    """The force if it is that of the contacts; inertia adds to the spring's force on a slider with mass."""
    return force[:0] if "mass" in case.drive else force


def bounding_factor(replicas: int) -> float:
    """Standard errors that bound the ensemble with the probability of SIGMAS normal ones, for an error that is known
    from a scatter of so many replicas (Student's t); 1 replica: from the variance between many contacts."""
    if replicas == 1:
        return SIGMAS
    return float(special.stdtrit(replicas - 1, 1.0 - special.ndtr(-SIGMAS)))


def invariants(
    holding: Array, force: Array, error: float, contacts: Contacts, path: Array
) -> tuple[str, ...]:
    """What cannot be, in words: shares outside 0 to 1, forces beyond the largest stretch, by more than rounding."""
    if not np.isfinite(error):
        return ()
    faults, unit = list[str](), contacts.mean_threshold
    if (np.abs(holding - 0.5) > 0.5 + error + 1e-9).any():
        faults.append(f"between {holding.min():.3g} and {holding.max():.3g} of the contacts hold")
    distance = np.abs(np.diff(path, prepend=0.0)).sum() + max(map(abs, contacts.start.span))
    largest = float(np.abs(force).max()) if force.size else 0.0
    if contacts.stiffness == "independent" and largest > distance / unit + error + 1e-9:
        faults.append(f"a force of {largest:.3g} mean thresholds is beyond the whole way")
    return tuple(faults)

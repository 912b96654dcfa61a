"""The promise on force_error: it bounds the true error, and not by much too much.

Over ordinary scenes - every law of thresholds, start, law of contacts and drive in turn - it bounds the true error in
at least 99 of 100, its median is at most 30 times the true error (or round-off), and `success` is never True beside an
error above 3 times the tolerance; a refusal is a failure. Far corners, which may be refused, are asked the first and
the last. `make promise` takes 1,000 scenes; fewer are to hold no less, as far as chance lets them tell. The scenes were
drawn once and are kept as texts of calls, as those of tests/oracle, with closed forms or else what commit ee6a1b9
answered at its tightest, nan where neither is known. Beside that, all along the path, stands an answer at a thousandth
of the tolerance. Where a reference claims an error of its own, that is granted, and round-off. Scenes are judged as
the drawn ones of `mesofriction precision --coverage` are, by toolkit.stability.
"""

from __future__ import annotations

import dataclasses
import json
import os
import signal
from functools import cache
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest
import scipy.stats
from conftest import slow
from oracle.calls import evaluated
from oracle.judge import Given, load

import master
import origins
from toolkit.command import main
from toolkit.judge.closed_form import closed_form
from toolkit.stability.case import SIGMAS, Case, CaseAnswer, Question, Row, Truth, bounding_factor
from toolkit.stability.cohorts import by_cohorts
from toolkit.stability.coverage import as_lines, coverage
from toolkit.stability.diffusing import aged_lives
from toolkit.stability.drawn import KINDS, drawn
from toolkit.stability.heavy import by_equation_of_motion, by_steps
from toolkit.stability.renewal import by_renewal
from toolkit.stability.table import answered
from toolkit.stability.truths import gaussian

CASES, ALL = int(os.environ.get("FORCE_ERROR_CASES", "13")), 1000
FIRST = int(os.environ.get("FORCE_ERROR_FIRST", "0"))
DENSE = 400  # points of a path at which errors are looked for
SPARSE = {"pulled", "pulled_with_laws", "older_in_time"}  # not there: they take long
FINER = 0.05  # of what these claim, for a reference where the older version has none: a thousandth takes hours
FINEST = 1e-11  # tolerance of a reference: at times of 1e5 their rounding alone makes 1e-12
MISSED = 0.01  # of the scenes may be off by more than they claim
NEAR = 30.0  # times the true error, or round-off: half of the claims are no larger
# Scenes whose answer by the older version is off by more than it claims, so that no answer could agree with both: 458
# by 5.6e-9 where it claims 2.9e-10, as a rigid slider led along the same X(t) shows; 747 by 1.1e-6 where it claims
# 3.2e-11, see test_the_older_answer_of_a_first_slip_is_off.
OLDER_IS_OFF = ("458", "747")


@cache
def scenes() -> dict[str, Given]:
    """Ordinary ones are named by numbers, far ones `far` and a number."""
    found = load(Path(__file__).parent / "oracle" / "promised.npz")
    for name in OLDER_IS_OFF:
        found[name] = dataclasses.replace(found[name], success=False)
    return found


def question(asked: Given) -> Question:
    """A scene as a case of toolkit.stability: forces at its points, then all along its path."""
    contacts, path, tolerance, drive = evaluated(asked.call, force=lambda *a, **drive: (*a, drive))
    mean, each = contacts.mean_threshold, np.arange(len(path))
    at = each if asked.kind in SPARSE else np.union1d(np.linspace(0.0, each[-1], DENSE), each)
    path, given = np.interp(at, each, path), np.isin(at, each)
    if "time" in drive:
        drive["time"] = np.interp(at, each, drive["time"])
    claimed = [np.inf]

    def ask() -> CaseAnswer:
        found = master.solve(contacts, path, tolerance, **drive)
        claimed[0] = found.force_error
        values = found.force / mean
        if values.size == path.size:
            values = np.concatenate([values[given], values])
        return CaseAnswer(values, claimed[0], found.success, tolerance, found.message)

    def truth() -> Truth:
        # the older version fitted other thresholds to samples: their survivals differ by some 1e-10
        kept = asked.success and "from_samples" not in asked.call
        values, errors = asked.values, asked.claims if kept else np.full(each.size, np.inf)
        errors = np.where(np.isfinite(values), errors, np.inf)
        values = np.nan_to_num(values)
        if np.isfinite(errors).any() and asked.kind in SPARSE:
            return Truth(np.tile(values, 2), np.tile(errors, 2), "ee6a1b9")
        finest = min(1e-3 * tolerance, max(0.2 * claimed[0], FINEST))
        if asked.kind in SPARSE:
            finest = max(FINER * min(tolerance, claimed[0]), FINEST)
        finer = master.solve(contacts, path, finest, **drive)
        errors = np.append(errors, np.full(path.size, finer.force_error))
        return Truth(np.append(values, finer.force / mean), errors, "ee6a1b9; tighter tolerance")

    return Question(asked.kind, asked.call[:60], "master", ask, truth)


def test_the_older_answer_of_a_first_slip_is_off() -> None:
    """Contacts hold up to x_0, where thresholds begin; there their force falls faster than the spring's, all slip and
    are reset: before that, and after it until contacts break again, F = (X_T - X_T0) K/(1 + K) in units of N_c <k>."""
    asked = scenes()["747"]
    contacts, path, tolerance, drive = evaluated(asked.call, force=lambda *a, **drive: (*a, drive))
    spring, drive_at = drive["spring"], np.array(path)
    slip_at = contacts.thresholds.breakpoints[0] * (1.0 + 1.0 / spring)
    exact = (drive_at - np.where(drive_at < slip_at, 0.0, slip_at)) * spring / (1.0 + spring)
    found = master.solve(contacts, path, tolerance, **drive)
    assert np.abs(found.force - exact).max() < found.force_error < 1e-9
    assert np.abs(asked.values * contacts.mean_threshold - exact).max() > 1e-6


def test_force_error_is_the_promise_it_is_said_to_be() -> None:
    numbers = range(FIRST, min(FIRST + CASES, ALL))
    rows = []
    for number in numbers:
        rows += answered(question(scenes()[str(number)]))
        if len(rows) % 50 == 0:  # a run of all takes half an hour
            print(f"{len(rows)} of {len(numbers)}", flush=True)
    print("\n".join(as_lines(rows)))
    found = coverage(rows)
    failed, ratios = len(numbers) - found.bounded.hold, found.ratios
    if len(numbers) >= ALL:
        most, least = MISSED * len(numbers), 0.5 * len(ratios)
    else:
        most = scipy.stats.binom.ppf(0.99, len(numbers), 0.5 * MISSED)
        least = scipy.stats.binom.ppf(0.01, len(ratios), 0.5)
    assert failed <= most and not found.overruns, as_lines(rows)
    assert len(ratios) > 0.3 * len(numbers) and (ratios <= NEAR).sum() >= least, as_lines(rows)


@pytest.mark.slow
def test_far_corners_keep_it_where_they_are_answered() -> None:
    """Most are; what is refused claims nothing. No call has a wall_time, so that no answer depends on the machine."""
    far = [one for name, one in scenes().items() if name.startswith("far")][: max(CASES // 4, 11)]
    rows = [row for one in far for row in answered(question(one)) if row.verdict != "refused"]
    assert len(rows) > 0.9 * len(far)
    found = coverage(rows)
    failed = len(rows) - found.bounded.hold
    assert failed <= scipy.stats.binom.ppf(0.99, len(rows), 0.5 * MISSED), as_lines(rows)
    assert not found.overruns, as_lines(rows)


class Weakening(origins.OrderedThresholds):
    """x_s(t) = x_s0 e^-t, a law that neither road to the truth knows."""

    law = "weakening"

    def __init__(self, fresh: object) -> None:
        """`fresh`: thresholds at birth."""
        self.at_start = fresh

    def birth_threshold(self, x: Any, age: Any, travelled: Any) -> Any:
        """x_s0 of the contact that breaks here."""
        return x * np.exp(np.minimum(age, 600.0))


def test_cohorts_agree_with_closed_forms_and_the_renewal_equation() -> None:
    """Within the error that they claim: from a start with a width, with a delay, one shorter than a third of the way
    between two points, too, and with heat."""
    path = np.linspace(0.0, 3.0, 17)
    spread = origins.Contacts(origins.gaussian(1.0, 0.1), origins.gaussian_start(0.05, 0.05))
    wait, hurry = (
        origins.Contacts(origins.lubricated(1.0), 0.1, delay=origins.Delay(steps * 3.0 / 256.0))
        for steps in (30.0, 2.0)
    )
    warm = origins.Contacts(origins.gaussian(1.0, 0.1), thermal=origins.Thermal("stiff", 0.05, 2.0))
    for contacts in (spread, wait, hurry, warm):
        exact = (gaussian if contacts is spread else by_renewal)(contacts, path)
        found = by_cohorts(contacts, path, 1.0 * path)
        assert np.abs(found.values - exact.values).max() < found.error + exact.error < 2e-3
    # at speed 1 the clock runs on where the path turns back
    back = np.append(path, path[-2::-1])
    found, timed = (by_cohorts(wait, back, *time) for time in ((), (3.0 / 16.0 * np.arange(33.0),)))
    assert np.abs(found.values - timed.values).max() < 1e-9
    with pytest.raises(origins.InputError):
        by_cohorts(origins.Contacts(origins.gaussian(1.0, 0.1), stiffness="linked"), path)
    with pytest.raises(origins.InputError, match="a step would be longer"):
        by_cohorts(origins.Contacts(origins.gaussian(1.0, 0.1), delay=origins.Delay(1e-3)), path)
    weakening = origins.Contacts(Weakening(origins.gaussian(1.0, 0.1)))
    with pytest.raises(origins.InputError, match="their thresholds stay as drawn, or grow"):
        by_cohorts(weakening, path)
    with pytest.raises(origins.InputError, match="only with a delay, heat, linked stiffness or ag"):
        by_renewal(weakening, path)


@pytest.mark.parametrize(
    ("spring", "mass", "damping", "start"),
    [slow(3.576, 0.2831, 0.0, 0.187), (1.2, 0.0128, 0.075, 0.0)],
)
def test_roads_of_a_slider_with_mass_agree(
    spring: float, mass: float, damping: float, start: float
) -> None:
    """The equation of motion on F in closed form, even steps with cohorts, and master.solve, within what each claims;
    the first slider turns and goes on again within one step of an integrator that is not watched."""
    contacts = origins.Contacts(origins.gaussian(1.0, 0.0613), start)
    path = start / spring + np.linspace(0.1, 2.8 * (1.0 + 0.2 / spring), 33)
    drive = {"spring": spring, "mass": mass, "damping": damping}
    exact, steps = (road(contacts, path, drive) for road in (by_equation_of_motion, by_steps))
    apart = np.abs(steps.values - exact.values)
    assert np.isfinite(exact.error).all() and (apart <= steps.error + exact.error).all()
    assert steps.error.max() < 1e-4
    for tolerance in (1e-4, 1e-6):
        found = master.solve(contacts, path, tolerance, **drive)
        assert found.success, found.message
        assert np.abs(found.force - exact.values).max() < found.force_error
    with pytest.raises(origins.InputError):
        by_equation_of_motion(contacts.replace(start=-0.1), path, drive)
    wait = contacts.replace(delay=origins.Delay(1e-4))
    with pytest.raises(origins.InputError):
        by_steps(wait, path, drive)


def test_finite_volumes_meet_the_first_passage_of_thresholds_that_diffuse_freely() -> None:
    """An inverse Gaussian of the way, by the second order of the steps; and F that follows is the master equation's."""
    rate, diffuse = 1e-2, origins.gaussian(0.5, 1e4)
    free = origins.Contacts(origins.gaussian(0.5, 0.05), ageing=origins.Ageing(diffuse, rate))
    fresh, errors = np.linspace(0.1, 0.9, 801), list[float]()
    for halvings in (1, 2, 3):
        way = np.linspace(0.0, 2.0, 64 * 2**halvings + 1)
        x, breaks = way[1:, None], aged_lives(free, 1.0, way, halvings)[0][1:]
        passing = np.exp(-((fresh - x) ** 2) / (4.0 * rate * x)) / np.sqrt(
            4.0 * np.pi * rate * x**3
        )
        exact = np.trapezoid(free.thresholds.pdf(fresh) * fresh * passing, fresh, axis=1)
        errors.append(float(np.abs(breaks - exact).max()))
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.2)
    assert np.log2(errors[1] / errors[2]) == pytest.approx(2.0, abs=0.2)
    old, path = origins.gaussian(0.8, 0.05), np.linspace(0.0, 4.0, 17)
    contacts = origins.Contacts(origins.gaussian(0.5, 0.05), ageing=origins.Ageing(old, 1e-3))
    found, known = master.solve(contacts, path, 1e-6), by_renewal(contacts, path)
    differ = np.abs(found.force / contacts.mean_threshold - known.values).max()
    assert found.success and differ <= found.force_error + known.error < 3e-5
    with pytest.raises(origins.InputError, match="ageing"):
        by_renewal(contacts.replace(start=0.1), path)
    spread = origins.Contacts(old, origins.gaussian_start(0.1, 0.01))
    with pytest.raises(origins.InputError, match="start"):
        by_renewal(spread, path)
    with pytest.raises(origins.InputError, match="only with a delay, heat, linked stiffness or ag"):
        by_renewal(contacts.replace(reforming=origins.boltzmann_reforming(1e-3)), path)


@pytest.mark.parametrize(
    ("shape", "rate", "delay"),
    [
        *(slow(*each) for each in ((2.5, 0.0, 0.0), (2.5, 0.7, 1.3), (6.0, 0.0, 0.4))),
        (3.3, 0.7, 0.0),
    ],
)
@pytest.mark.filterwarnings("ignore::origins.laws.temperature.TooHot")
def test_force_is_the_laplace_inversion_of_its_transform(
    shape: float, rate: float, delay: float
) -> None:
    """Of relaxed contacts with gamma thresholds of mean 1, which break far above all barriers at one rate as well:
    survivals E = exp(-rate x) S(x) and stretches K = x E have closed transforms, and de Hoog's method, which knows
    neither stretches nor cohorts, inverts F^ = K^ (1 + e^(-sd) (1/s - E^)/D) of docs/equations.md."""

    def transform(s: Any) -> Any:
        z, late = s + rate, mpmath.exp(-s * delay)
        left = (1.0 + z / shape) ** -shape
        holds = (1.0 - left) / z
        stretched = holds / z - left / (z * (1.0 + z / shape))
        holding = holds * late + (1.0 - late) / s
        return stretched * (1.0 + late * (1.0 / s - holds) / holding)

    at = np.array([0.3, 0.9, 1.7, 6.0])  # not a whole number of delays, where F bends
    with mpmath.workdps(25):
        known = [
            float(mpmath.invertlaplace(transform, x, method="dehoog", degree=40))
            for x in at.tolist()
        ]
    contacts = origins.Contacts(
        scipy.stats.gamma(shape, scale=1.0 / shape),
        thermal=origins.Thermal("soft", 1e12, rate) if rate else None,
        delay=origins.Delay(delay) if delay else None,
    )
    found = master.solve(contacts, at, 1e-9)
    differ = np.abs(found.force / contacts.mean_threshold - known).max()
    assert found.success and differ <= found.force_error + 1e-12


@pytest.mark.slow  # quick: the ensemble sees one, two tests below
def test_a_fault_of_both_answers_of_the_master_equation_is_seen(monkeypatch: Any) -> None:
    """A delay that is too long at every tolerance: the cohorts contradict the finer answer, and are the truth."""
    solve, number = master.solve, list(KINDS).index("delay in time")

    def wrong(contacts: Any, *arguments: Any, **named: Any) -> Any:
        late = origins.Delay(1.01 * contacts.delay.time)
        return solve(contacts.replace(delay=late), *arguments, **named)

    monkeypatch.setattr(master, "solve", wrong)
    row, *_ = answered(drawn(1, number))
    assert row.verdict == "wrong" and row.road.startswith("cohorts") and row.error > 1e-4


def test_exact_values_beside_others_have_the_ensemble_as_a_road(monkeypatch: Any) -> None:
    """The finer answer is the truth where the ensemble bears it out; a fault of both, F one part in 50 off, is seen."""
    solve, solutions = master.solve, list[Any]()

    def kept(*arguments: Any, **named: Any) -> Any:
        solutions.append(solve(*arguments, **named))
        return solutions[-1]

    monkeypatch.setattr(master, "solve", kept)
    monkeypatch.setattr("toolkit.stability.drawn.BREAKS", 1e6)
    case = drawn(1, 350)  # on a path that turns
    assert case.contacts().thresholds.atoms[0].size
    (row, *_) = answered(case)
    assert row.verdict in ("exact", "within tolerance")
    assert row.road.endswith("tighter tolerance, beside the ensemble at 1e+06 breaks")

    def wrong(*arguments: Any, **named: Any) -> Any:
        found = solutions.pop(0)
        return dataclasses.replace(found, force=1.02 * found.force)

    monkeypatch.setattr(master, "solve", wrong)
    (row, *_) = answered(drawn(1, 350))
    assert row.verdict == "wrong" and row.road.startswith("the ensemble")


@pytest.mark.parametrize("many", [len(KINDS) // 4, slow(len(KINDS))], ids=["quarter", "all"])
def test_drawn_cases_by_the_command(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], many: int
) -> None:
    """One of each kind, held against other roads, the ensemble beside; the whole 1,000 take minutes."""
    words = [
        "precision",
        "--coverage",
        "--cases",
        str(many),
        "--seed",
        "12",  # whose kernels of the ensemble test_agreement compiles, too, at some seconds each
        "--out",
        str(tmp_path / "out"),
    ]
    status = main(words)
    page = capsys.readouterr().out
    assert status == 0, page
    kept = json.loads((tmp_path / "out" / "coverage.json").read_text())
    assert kept["held"] == kept["master_cases"] == many and kept["promise_kept"]
    assert len((tmp_path / "out" / "coverage.csv").read_text().splitlines()) == 1 + len(
        kept["rows"]
    )
    roads = [(row["road"], row["group"]) for row in kept["rows"] if row["solver"] == "master"]
    assert sum("tighter" not in road for road, _ in roads) >= many // 2
    assert not [kind for road, kind in roads if road.endswith("tighter tolerance")]
    assert "errors within 3 standard errors; 99.7 ± " in page


def test_an_interrupted_coverage_holds_what_is_known(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A signal comes with the third case: the answers to two are written, and said to be no more."""

    def until_the_signal(seed: int, number: int) -> Case:
        if number == 2:
            signal.raise_signal(signal.SIGINT)
        return drawn(seed, number)

    monkeypatch.setattr("toolkit.stability.coverage.drawn", until_the_signal)
    folder = tmp_path / "out"
    assert main(["precision", "--coverage", "--out", str(folder)]) == 130
    kept = json.loads((folder / "coverage.json").read_text())
    known = len(kept["rows"])
    assert kept["interrupted"] and kept["held"] == kept["master_cases"] == 2
    last = capsys.readouterr().err.splitlines()[-1]
    assert last == f"mesofriction: interrupted; the {known} answers so far are written to {folder}"
    lines = (folder / "coverage.txt").read_text().splitlines()
    assert lines[-1] == f"interrupted after {known} answers"


def test_what_rounded_positions_do_not_allow_is_missed_at_once() -> None:
    """Thresholds a millionth to a thousandth wide, where a last place of X changes survivals by 1e-13 to 1e-10."""
    path = np.linspace(0.0, 3.0, 61)
    for width in (1e-3, 1e-6):
        contacts = origins.Contacts(origins.gaussian(1.0, width))
        found = master.solve(contacts, path, 1e-13)
        exact, known = closed_form(contacts, path)
        assert (
            not found.success and found.nodes < 4_000
        )  # some 1,500; halved without end there are millions
        assert np.abs(found.force - exact).max() <= found.force_error + known
        assert found.force_error < 1e-6 * 1e-9 / width


def test_errors_beyond_their_bars_are_told() -> None:
    """Normal errors are within their bars, those of bars a quarter too short are not; one wrong claim of 50 is one too
    many, as is one that is refused."""
    normal = np.random.default_rng(5).standard_normal(1000)

    def row(solver: str, verdict: Any, error: float, claim: float) -> Row:
        return Row("", "", solver, verdict, error, 0.0, claim, 0.0, "by hand", "")

    def of_ensemble(scale: float) -> list[Row]:
        return [row("ensemble", "within tolerance", abs(z), scale * SIGMAS) for z in normal]

    assert coverage(of_ensemble(1.0)).sigmas_kept
    assert not coverage(of_ensemble(0.75)).sigmas_kept
    few = np.random.default_rng(5).standard_t(
        15, 1000
    )  # of 16 replicas on a spring, beside their own scatter
    on_spring = [row("ensemble", "within tolerance", abs(t), bounding_factor(16)) for t in few]
    assert not coverage(on_spring).sigmas_kept
    assert coverage([dataclasses.replace(one, group="spring") for one in on_spring]).sigmas_kept
    good = [row("master", "within tolerance", 1e-9, 1e-8)] * 49
    assert coverage(good).promise_kept
    wrong, refused = row("master", "wrong", 1e-7, 1e-8), row("master", "refused", np.nan, np.nan)
    assert not coverage([*good, wrong]).promise_kept
    assert not coverage([*good, refused]).promise_kept
    cut = row("master", "slow", np.nan, np.inf)
    page = "\n".join(as_lines([*good, wrong, refused, cut, refused]))
    assert "in 49 of 53 cases, 92.5 %" in page
    assert "2 refused, 1 cut or not known, and 1 that claim too little" in page

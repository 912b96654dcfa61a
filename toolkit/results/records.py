"""What the toolkit needs of a solver's result, and what it keeps of a whole run.

The solvers' results share no base class: whatever has these attributes will do, a record read back from a file too.
"""

import tomllib
from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Protocol

import numpy as np
import numpy.typing as npt

from origins.brief import brief
from origins.thresholds.law import Thresholds
from origins.thresholds.quadrature import panel_edges
from toolkit.scene.interfaces import Number
from toolkit.scene.scene import SceneTable, read_table
from toolkit.scene.sweep import SweepRecord

if TYPE_CHECKING:
    from eq_model.histogram import Histogram
    from master.paper.q15_transient import AgeingTransient
    from master.soft.regime import Regime, Verdict
    from master.soft.slips import Slips
    from master.soft.solution import SoftSolution

Array = npt.NDArray[np.float64]

OWN_UNIT = "length unit of the thresholds"
_PER_PANEL = 24


class Curve(Protocol):
    """A force over a path: `path`, `force` (n,) lengths, `holding` (n,) the fraction of contacts that hold."""

    @property
    def path(self) -> Array: ...
    @property
    def force(self) -> Array: ...
    @property
    def holding(self) -> Array: ...
    @property
    def run_time(self) -> float: ...


class Solved(Curve, Protocol):
    """The master equation's answer; `force_error` is relative to the mean threshold."""

    @property
    def force_error(self) -> float: ...
    @property
    def success(self) -> bool: ...
    @property
    def message(self) -> str: ...


class Simulated(Curve, Protocol):
    """The ensemble's answer; `force_standard_error` and `step_error` (n,) are lengths, the error of the fraction that
    holds is a number.

    `histograms` are those of stretches and thresholds that were asked for; times are in seconds.
    """

    @property
    def force_standard_error(self) -> Array: ...
    @property
    def step_error(self) -> Array: ...
    @property
    def holding_standard_error(self) -> Array: ...
    @property
    def histograms(self) -> Sequence["Histogram"]: ...
    @property
    def contacts(self) -> int: ...
    @property
    def success(self) -> bool: ...
    @property
    def message(self) -> str: ...
    @property
    def breaks(self) -> int: ...
    @property
    def breaks_per_rank(self) -> Sequence[int]: ...
    @property
    def compile_time(self) -> float: ...


@dataclass(frozen=True)
class SolvedRecord:
    """A master equation's answer read back from a file."""

    path: Array
    force: Array
    holding: Array
    force_error: float
    run_time: float
    success: bool
    message: str

    __repr__ = brief


@dataclass(frozen=True)
class SoftRecord(SolvedRecord):
    """A soft slider's: `path` is the drive's, `position` (n,) the slider's, and its slips, arrays of shape (m,).

    All lengths; `balance` is where the drive stands at t = 0, and `period` nan for fewer than two slips. `slips` and
    `regime` are those of master.solve's own answer.
    """

    balance: float
    position: Array
    slip_drive: Array
    slip_before: Array
    slip_after: Array
    slip_force_before: Array
    slip_force_after: Array
    slip_drive_error: float
    period: float
    verdict: "Verdict"
    reason: str
    critical_spring: float
    critical_spring_error: float
    stiffness_ratio: float
    trend: float

    __repr__ = brief

    @property
    def slips(self) -> "Slips":
        from master.soft.slips import Slips

        return Slips(**{field.name: getattr(self, f"slip_{field.name}") for field in fields(Slips)})

    @property
    def regime(self) -> "Regime":
        from master.soft.regime import Regime

        own = {
            "slips": int(self.slip_drive.size),
            "trend": None if np.isnan(self.trend) else self.trend,
        }
        return Regime(
            **{
                field.name: own.get(field.name, getattr(self, field.name))
                for field in fields(Regime)
            }
        )


@dataclass(frozen=True)
class AgeingRecord(SolvedRecord):
    """That of the paper's closure of ageing (Q15), and what it did not keep: at each X of `path`, which may end early,
    the mass of P_c less 1 and its weight below 0; `outrun` is the X from which contacts outrun P_c, inf if none."""

    mass_defect: Array
    positivity_defect: Array
    outrun: float

    __repr__ = brief


def ageing_record(solution: "AgeingTransient") -> AgeingRecord:
    """What is kept of a transient in the paper's closure of ageing."""
    return AgeingRecord(
        **{field.name: getattr(solution, field.name) for field in fields(AgeingRecord)}
    )


def soft_record(solution: "SoftSolution") -> SoftRecord:
    """What is kept of a soft slider's solution."""
    slips, regime = solution.slips, solution.regime
    return SoftRecord(
        **{field.name: getattr(solution, field.name) for field in fields(SolvedRecord)},
        balance=solution.balance,
        position=solution.position,
        **{f"slip_{field.name}": getattr(slips, field.name) for field in fields(slips)},
        period=np.nan if solution.period is None else solution.period,
        verdict=regime.verdict,
        reason=regime.reason,
        critical_spring=regime.critical_spring,
        critical_spring_error=regime.critical_spring_error,
        stiffness_ratio=regime.stiffness_ratio,
        trend=np.nan if regime.trend is None else regime.trend,
    )


@dataclass(frozen=True)
class SimulatedRecord:
    """An ensemble's answer read back from a file."""

    path: Array
    force: Array
    holding: Array
    force_standard_error: Array
    step_error: Array
    holding_standard_error: Array
    histograms: Sequence["Histogram"]
    contacts: int
    breaks: int
    breaks_per_rank: tuple[int, ...]
    run_time: float
    compile_time: float
    success: bool
    message: str

    __repr__ = brief


@dataclass(frozen=True)
class ThresholdCurve:
    """P_c(x) sampled for a picture: `x`, `density`, `survival` of shape (m,), and the law's exact single values.

    `unit` is that of every length of the run: "m" where the law comes from a surface, else the scene's own.
    """

    x: Array
    density: Array
    survival: Array
    atoms: Array
    atom_weights: Array
    unit: str

    __repr__ = brief


@dataclass(frozen=True)
class Result:
    """A run of a scene; lengths are in the unit `thresholds.unit`, run times in s.

    Attributes
    ----------
    name, title, text, version : str
        Of the scene, its TOML text, and this package's version.
    mean_threshold : float
        <x_s>, a length.
    thresholds : ThresholdCurve
        P_c as drawn: `x`, `density`, `survival`, `atoms`, `atom_weights`, `unit`.
    master : Solved or None
        `path`, `force` = F/(N_c<k>) (lengths), `holding` (a fraction), each of shape (n,); `force_error` (in <x_s>),
        `success`, `message`, `run_time`; a SoftRecord where a spring pulls, an AgeingRecord in the paper's closure of
        ageing. None where not asked for.
    eq : Simulated or None
        `path`, `force`, `holding`, `force_standard_error` and `step_error` (lengths), `holding_standard_error`, each of
        shape (n,);
        `histograms`, of eq_model.histogram.Histogram, each read when it is asked for; `contacts` followed, `breaks`,
        `breaks_per_rank`, `success`, `message`, `run_time`, `compile_time`. A run that went on from a checkpoint counts
        the `run_time` of all launches, each its slowest rank's, and the breaks of the earlier ones on rank 0: a note
        says so. None where not asked for.
    time : array of shape (n,)
        When each point of the path is reached, s for a surface, else in the scene's own unit; empty without a path.
    sweep : SweepRecord or None
        F_k, what holds and K* along speeds, temperatures, rates of ageing or delays: SweepRecord. None
        where not asked for.
    notes : tuple of str
        What to keep in mind: where samples, surface or load strain the thresholds, what makes a run hopeless, that it
        went on from a checkpoint.
    interface : dict or None
        For a rough surface, its contacts in SI units: a Number (`value`, `error`, `unit`) by name.
    """

    name: str
    title: str
    text: str
    version: str
    mean_threshold: float
    thresholds: ThresholdCurve
    master: Solved | None
    eq: Simulated | None
    notes: tuple[str, ...] = ()
    interface: dict[str, Number] | None = None
    sweep: SweepRecord | None = None

    __repr__ = brief

    @property
    def asked(self) -> SceneTable:
        """The scene's tables, defaults filled in."""
        return read_table(tomllib.loads(self.text))

    @property
    def papers_closure(self) -> bool:
        """Whether the master equation is solved in a closure of the paper that single contacts do not follow."""
        laws = self.asked.contacts.thermal, self.asked.contacts.ageing
        return any(law is not None and law.get("closure") == "paper" for law in laws)

    @property
    def time(self) -> Array:
        from toolkit.scene.drive import make_drive

        if self.asked.drive is None:
            return np.empty(0)
        drive = make_drive(self.asked.drive)
        if drive.time is not None:
            return drive.time
        pulled = next((one for one in (self.master, self.eq) if hasattr(one, "balance")), None)
        begin = 0.0 if pulled is None else pulled.balance
        return np.abs(np.diff(drive.path, prepend=begin)).cumsum() / drive.velocity

    @property
    def success(self) -> bool:
        """Whether every solver reached what was asked of it."""
        return all(
            answer is None or answer.success for answer in (self.master, self.eq, self.sweep)
        )


def sample_curve(thresholds: Thresholds) -> ThresholdCurve:
    """P_c(x) on points close enough together for a picture of every peak and gap, and on both sides of each jump."""
    atoms, weights = thresholds.atoms
    tail = np.geomspace(1e-6, 0.5, 100)
    quantiles = np.concatenate([thresholds.ppf(tail), thresholds.isf(tail)])
    upper = 1.05 * quantiles.max()
    edges = np.unique(
        np.concatenate([[0.0], panel_edges(thresholds, upper), thresholds.breakpoints, [upper]])
    )
    within = np.linspace(edges[:-1], edges[1:], _PER_PANEL).ravel()
    jumps = thresholds.breakpoints
    x = np.unique(np.concatenate([quantiles, within, jumps * (1.0 - 1e-12), jumps * (1.0 + 1e-12)]))
    unit = "m" if thresholds.interface is not None else OWN_UNIT
    return ThresholdCurve(x, thresholds.pdf(x), thresholds.sf(x), atoms, weights, unit)

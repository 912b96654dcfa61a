"""What is kept of each solver's answer, and of a whole run."""

import tomllib
from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from origins.brief import brief
from origins.domains.rotated import DomainSamples
from origins.thresholds.law import Thresholds
from origins.thresholds.quadrature import panel_edges
from toolkit.scene.interfaces import Number
from toolkit.scene.sweep import SweepRecord
from toolkit.scene.tables import SceneTable, read_table

if TYPE_CHECKING:
    from eq_model import CoupledSlips
    from eq_model.histogram import Histogram
    from master.soft.regime import Regime, Verdict
    from master.soft.slips import Slips

Array = npt.NDArray[np.float64]
Whole = npt.NDArray[np.int64]

OWN_UNIT = "length unit of the thresholds"
_PER_PANEL = 24


@dataclass(frozen=True)
class SolvedRecord:
    """A master equation's answer: F = `force` over `path` (lengths, shape (n,)), `holding`, the fraction of contacts
    that hold, `force_error` in mean thresholds, `run_time` in s. The solvers' own answers have these fields, and
    more."""

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


@dataclass(frozen=True)
class SimulatedRecord:
    """An ensemble's answer: arrays of shape (n,), lengths but for the fraction that holds and its error; `histograms`
    are those that were asked for; times are in s. The ensemble's own answer has these fields."""

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
class CoupledRecord(SimulatedRecord):
    """That of contacts on a soft slider: `path` is the drive's, and of the replicas' slips arrays of shape (m,).

    Fields as of eq_model.CoupledResult, whose `slips` are these: lengths, but for whole numbers `slip_replica`,
    `slip_number` and `slip_breaks`.
    """

    position: Array
    position_standard_error: Array
    positions: Array
    forces: Array
    avalanches: Whole
    slip_fraction: float
    balance: float
    slip_replica: Whole
    slip_number: Whole
    slip_drive: Array
    slip_before: Array
    slip_after: Array
    slip_force_before: Array
    slip_force_after: Array
    slip_breaks: Whole

    __repr__ = brief

    @property
    def slips(self) -> "CoupledSlips":
        from eq_model import CoupledSlips

        return CoupledSlips(
            **{field.name: getattr(self, f"slip_{field.name}") for field in fields(CoupledSlips)}
        )


Curve = SolvedRecord | SimulatedRecord


def record_of(answer: Any) -> Any:
    """What is kept of a solver's answer: a record where the answer has parts of its own, else itself."""
    marks = {"avalanches": CoupledRecord, "regime": SoftRecord, "mass_defect": AgeingRecord}
    kind: Any = next((kind for mark, kind in marks.items() if hasattr(answer, mark)), None)
    if kind is None:
        return answer
    values: dict[str, Any] = {}
    for name in (field.name for field in fields(kind)):
        if name.startswith("slip_") and hasattr(answer.slips, name.removeprefix("slip_")):
            values[name] = getattr(answer.slips, name.removeprefix("slip_"))
        else:
            values[name] = getattr(answer if hasattr(answer, name) else answer.regime, name)
    return kind(**{name: np.nan if value is None else value for name, value in values.items()})


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
    master : SolvedRecord or None
        `path`, `force` = F/(N_c<k>) (lengths), `holding` (a fraction), each of shape (n,); `force_error` (in <x_s>),
        `success`, `message`, `run_time`; a SoftRecord where a spring pulls, an AgeingRecord in the paper's closure of
        ageing. None where not asked for.
    eq : SimulatedRecord or None
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
    domains : origins.DomainSamples or None
        For islands, their barriers and angles; not kept in the folder, but drawn there.
    """

    name: str
    title: str
    text: str
    version: str
    mean_threshold: float
    thresholds: ThresholdCurve
    master: SolvedRecord | None
    eq: SimulatedRecord | None
    notes: tuple[str, ...] = ()
    interface: dict[str, Number] | None = None
    sweep: SweepRecord | None = None
    domains: DomainSamples | None = None

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

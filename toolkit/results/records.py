"""The records of each solver's answer, and of a whole run."""

import tomllib
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
import numpy.typing as npt

from origins.brief import brief
from origins.domains.rotated import DomainSamples
from origins.errors import InputError, positive, refuse
from origins.thresholds.law import Array, Thresholds
from origins.thresholds.quadrature import panel_edges
from toolkit.results.dataset import as_dataset
from toolkit.results.html import as_html
from toolkit.results.kinds import ENERGIES
from toolkit.results.points import SweepRecord
from toolkit.scene.drive import has_path, make_drive
from toolkit.scene.interfaces import Number
from toolkit.scene.scale import Scale, length_unit_of, of_surface, without_stiffness
from toolkit.scene.tables import SceneTable, read_table

OWN_UNIT = "length unit of the thresholds"
_PER_PANEL = 24


@dataclass(frozen=True)
class SolvedRecord:
    """A master equation's answer: F = `force` over `path` (lengths, shape (n,)), `holding`, the fraction of contacts
    that hold, `force_error` in mean thresholds, `run_time` in s.

    A soft slider's `path` is the drive's; `position` (n,) the slider's, `balance` the drive's position at t = 0,
    `period` that of the slips, nan for fewer than two (lengths); `slips`, `regime`, `heat_left_out` and `note`, None
    where it is empty, are those of master.solve.

    Of a slider with mass `force` is the spring's; `contact_force` is that of the contacts, with an error of its own,
    `velocity` the slider's at each point, `energy` its energies by parts, with their largest errors in `energy_error`;
    `slips` have a `duration` and a `top_speed`.

    The paper's closure of ageing (Q15) has defects at each X of `path`, which may end early: the mass of P_c minus 1
    and its weight below 0; `outrun` is the X from which contacts outrun P_c, inf if they never do.
    """

    path: Array
    force: Array
    holding: Array
    force_error: float
    run_time: float
    success: bool
    message: str
    balance: float | None = None
    position: Array | None = None
    period: float | None = None
    slips: Any = None
    regime: Any = None
    note: str | None = None
    heat_left_out: float | None = None
    velocity: Array | None = None
    contact_force: Array | None = None
    contact_force_error: float | None = None
    energy: Any = None
    energy_error: Any = None
    mass_defect: Any = None
    positivity_defect: Any = None
    outrun: float | None = None

    __repr__ = brief


def record_of(answer: Any) -> SolvedRecord:
    """The record of the master equation's answer."""
    names = (field.name for field in fields(SolvedRecord))
    values: dict[str, Any] = {name: getattr(answer, name, None) for name in names}
    if values["slips"] is not None and values["period"] is None:
        values["period"] = np.nan
    values["note"] = values["note"] or None
    return SolvedRecord(**values)


def mean_energies(eq: Any) -> dict[str, float]:
    """Energies of an ensemble's sliders with mass, means over the replicas at the end of the path; "work" of the drive,
    and "start" as they began."""
    means = {name: float(getattr(eq.energy, name)[:, -1].mean()) for name in ENERGIES}
    return {"work": means.pop("drive"), "start": float(eq.energy.start.mean())} | means


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

    @property
    def in_metres(self) -> bool:
        return self.unit != OWN_UNIT


@dataclass(frozen=True)
class Result:
    """A run of a scene; lengths are in the unit `thresholds.unit`, run times in s.

    `text` is the scene's TOML text, `version` this package's, `mean_threshold` <x_s>, `thresholds` P_c as drawn.

    `master`, `eq` and `sweep` are each solver's answer, None where it was not requested; where a spring pulls `eq` is
    an eq_model.CoupledResult. For a run that continued from a checkpoint `run_time` is that of all launches, and rank 0
    counts the breaks of earlier ones.

    `notes` are warnings: where samples, surface or load are at the limits of the theory, what makes a run useless,
    that it continued from a checkpoint. `interface` has, for a rough surface, its contacts in SI units: a Number
    (`value`, `error`, `unit`) by name. `domains` are the barriers and angles of islands, which the folder's picture
    shows and its files do not contain.
    """

    name: str
    title: str
    text: str
    version: str
    mean_threshold: float
    thresholds: ThresholdCurve
    master: SolvedRecord | None
    eq: Any
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
    def curves(self) -> list[Any]:
        """What the solvers found along the path, the master equation's first."""
        return [curve for curve in (self.master, self.eq) if curve is not None]

    @property
    def timed(self) -> bool:
        """Whether the scene says when each point of the path is reached."""
        drive = self.asked.drive
        return drive is not None and drive.times is not None

    @property
    def papers_closure(self) -> bool:
        """Whether the master equation is solved in a closure of the paper that single contacts do not follow."""
        laws = self.asked.contacts.thermal, self.asked.contacts.ageing
        return any(law is not None and law.get("closure") == "paper" for law in laws)

    @property
    def time(self) -> Array:
        """Time of each point of the path, in s for a surface, else in the scene's unit; empty without a drive."""
        if self.asked.drive is None or not has_path(self.asked.drive):
            return np.empty(0)
        begin = getattr(self.master or self.eq, "balance", None) or 0.0
        return make_drive(self.asked.drive).arrival_times(begin)

    @property
    def scale(self) -> Scale:
        """The units of forces F/(N_c<k>) and springs K/(N_c<k>): N and N/m of a surface with drive.area, Pa and N/m³
        without it, N_c<k> of other thresholds and of a scene with units = "N_c<k>"."""
        if self.interface is None:
            return without_stiffness(self.thresholds.in_metres)
        values = {name: number.value for name, number in self.interface.items()}
        density, pressure = values.get("contact_density"), values.get("pressure")
        return of_surface(density, values["mean_stiffness"], pressure, self._area, self.asked.units)

    @property
    def _area(self) -> float | None:
        return None if self.asked.drive is None else self.asked.drive.area

    def per_area(self, shared: npt.ArrayLike) -> Array:
        """Forces of this result, F/(N_c<k>) in m, as shear stresses in Pa, or springs K/(N_c<k>) in N/m³; shape as
        given. Raises InputError where the thresholds are not those of a surface, or where a sweep gives each point its
        own N_c<k>."""
        self._refuse_swept("per_area", "contacts.thresholds", "contacts.interface")
        if self.interface is None or "contact_density" not in self.interface:
            hint = "needs <k> and the number of contacts, which a rough surface knows, or [contacts.interface] states"
            raise InputError(f"per_area: {hint}; forces are F/(N_c<k>)")
        density, stiffness = (self.interface[one] for one in ("contact_density", "mean_stiffness"))
        return density.value * stiffness.value * np.asarray(shared, float)

    def newtons(self, shared: npt.ArrayLike, area: float | None = None) -> Array:
        """Forces of this result, F/(N_c<k>) in m, in N on a nominal `area` in m², or springs K/(N_c<k>) in N/m.

        shared, result : of any one shape; `area` left out: the scene's drive.area. Raises InputError without one, and
        as `per_area` does.
        """
        if area is None:
            self._refuse_swept("newtons", "drive.area")
            area = self._area
        if self.interface is not None and area is None:
            refuse("area", area, "is missing: the scene has no drive.area; give one in m²")
        return self.per_area(shared) * (1.0 if area is None else positive("area", area))

    def _refuse_swept(self, name: str, *tables: str) -> None:
        """Refuse one factor for all forces where a sweep changes it from point to point."""
        for key in () if self.sweep is None else self.sweep.along:
            if key.startswith(tables):
                hint = "N_c<k> of each point is its own; sweep.columns has newtons and pascals"
                raise InputError(f"{name}: the sweep changes {key}; {hint}")

    def to_xarray(self) -> Any:
        """An xarray.Dataset of all arrays with their units, of a surface in SI units. Raises InputError where xarray is
        not installed."""
        return as_dataset(self)

    def _repr_html_(self) -> str:
        return as_html(self)

    def __dir__(self) -> list[str]:
        """Names that a user may want; without those of Python."""
        return [name for name in super().__dir__() if not name.startswith("_")]

    @property
    def success(self) -> bool:
        """Whether every solver reached its tolerance; not where an ensemble was asked for, and the wall time was over
        before it knew anything."""
        along_scene = self.sweep is None or self.sweep.smooth  # else the points have the ensembles
        nothing = self.eq is None and along_scene and self.asked.eq is not None
        found = self.master, self.eq, self.sweep
        return not nothing and all(one is None or one.success for one in found)


def sample_curve(thresholds: Thresholds) -> ThresholdCurve:
    """P_c(x) on points close enough together for a picture of every peak and gap, and on both sides of each jump."""
    atoms, weights = thresholds.atoms
    tail, jumps = np.geomspace(1e-6, 0.5, 100), thresholds.breakpoints
    quantiles = np.concatenate([thresholds.ppf(tail), thresholds.isf(tail)])
    upper = 1.05 * quantiles.max()
    edges = np.unique([0.0, *panel_edges(thresholds, upper), *jumps, upper])
    within = np.linspace(edges[:-1], edges[1:], _PER_PANEL).ravel()
    x = np.unique(np.concatenate([quantiles, within, jumps * (1.0 - 1e-12), jumps * (1.0 + 1e-12)]))
    own = length_unit_of(thresholds)
    unit = own if own == "m" else OWN_UNIT
    return ThresholdCurve(x, thresholds.pdf(x), thresholds.sf(x), atoms, weights, unit)

"""What is refused: calls and scenes, a line each, and what their one line says."""

import copy
import os
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from ase import Atoms
from ase.calculators.calculator import Calculator
from ase.constraints import FixAtoms
from conftest import slow
from scenes import ROUGH, Scan, scene, write
from scipy import stats

import eq_model
import master
import origins
import toolkit
from origins import Ageing, Contacts, Delay, Drive, Thermal

STRONG = {"hardness": 6e7, "shear_strength": 6e7, "force_coefficient": 2e10}
MATERIAL = origins.Material(3e9, local_friction=0.4, shear_modulus=1.1e9, **STRONG)
BARE = origins.Material(contact_modulus=1e9, local_friction=0.3)
SUMMITS = origins.moments_of_summits(radius=20e-6, std=0.2e-6, density=3e9)
ISLAND, PAIR = origins.triangular_island(2.5, 2, 2), origins.triangular_island(2.5, 2, 1)
HEIGHTS = np.random.default_rng(1).standard_normal((20, 20))
PERSSON = {"model": "persson", "patch_area": 1e-12}


def pressed(moments: origins.SpectralMoments = SUMMITS, **change: object) -> origins.Thresholds:
    """Greenwood and Williamson's thresholds under 1e5 Pa, but for what is changed."""
    asked = {"model": "gw", "law": "amontons", "material": MATERIAL, "pressure": 1e5}
    return origins.from_moments(moments, **(asked | change))


def stiffer(coefficient: float, exponent: float, **constants: float) -> origins.Material:
    law = origins.PowerLaw(coefficient, exponent)
    return origins.Material(1e9, local_friction=0.3, contact_stiffness=law, **constants)


def separated(pressure: float, material: origins.Material = MATERIAL, **options: str) -> float:
    return origins.separation_of_pressure(SUMMITS, pressure, material=material, **options)


def pressure_at(separation: float, **options: str) -> float:
    return origins.pressure_of_separation(SUMMITS, separation, material=MATERIAL, **options)


def surface(**change: object) -> np.ndarray:
    asked = {"shape": (32, 32), "pixel_size": 1.0, "hurst": 0.8, "rms_slope": 0.1, "seed": 1}
    return origins.self_affine_surface(**(asked | change))


def rotated(**change: object) -> origins.Thresholds:
    return origins.domains(**({"lattice_constant": 2.5, "stiffness": 1.0} | change))


def moments(heights: object, *pixel: object, **options: object) -> origins.SpectralMoments:
    return origins.spectral_moments(heights, *pixel, **options)


EMPTY, FIXED = Atoms(), ISLAND.copy()
FIXED.set_constraint(FixAtoms(range(4)))
ON = origins.substrate_calculator(origins.square_substrate())
LEVEL = origins.substrate_calculator(origins.fourier_substrate([[1.0, 0.0]], [1.0]))

GAUSSIAN, BOX = origins.gaussian(1.0, 0.2), origins.rectangular(0.5, 1.0)
GAP = origins.mixture([origins.rectangular(0.1, 0.5), origins.rectangular(1.0, 2.0)], [0.5, 0.5])
PAPER, AGEING = Thermal("soft", 0.1, closure="paper"), Ageing(origins.gaussian(1.2, 0.1), rate=1e-3)


class Wrong(Calculator):
    """The forces of cos x + cos y, and `share` of its energy."""

    implemented_properties = ["energy", "forces"]  # noqa: RUF012

    def __init__(self, share: float) -> None:
        super().__init__()
        self.share = share

    def calculate(self, *given: Any, **named: Any) -> None:
        super().calculate(*given, **named)
        xy = self.atoms.positions * [1.0, 1.0, 0.0]
        self.results = {"energy": self.share * float(np.cos(xy).sum()), "forces": np.sin(xy)}


class Half(origins.Thresholds):
    """A density that adds up to a half, and in Unbound a survival above 1."""

    def support(self) -> tuple[float, float]:
        return 0.0, 1.0

    def _pdf(self, x: np.ndarray) -> np.ndarray:
        return np.full_like(x, 0.5)


class Unbound(Half):
    def _sf(self, x: np.ndarray) -> np.ndarray:
        return 1.2 - x


class Careless(origins.Thresholds):
    """Exponential thresholds whose inverse is wrong by a part in 10^4."""

    def support(self) -> tuple[float, float]:
        return 0.0, np.inf

    def _pdf(self, x: np.ndarray) -> np.ndarray:
        return np.exp(-x)

    _sf = _pdf

    def _cdf(self, x: np.ndarray) -> np.ndarray:
        return -np.expm1(-x)

    def _quantiles(self, below: np.ndarray, above: np.ndarray) -> np.ndarray:
        x = -np.log(above)
        return np.where(below < above, x * (1.0 + 1e-4), x)


def simulate(path: Any = (0.0, 1.0), law: Any = GAUSSIAN, laws: Any = None, **asked: Any) -> Any:
    return eq_model.simulate(Contacts(law, **(laws or {})), path, **{"n_contacts": 10, **asked})


# what is called, and what its one line says
REFUSED = [
    (lambda: pressed(pressure=1e30), "summits would cover"),
    (lambda: pressed(pressure=1e9, height_law="exponential"), "bear at most"),
    (lambda: pressed(regime="mixed", material=BARE), "material.hardness = None"),
    (lambda: pressed(material=BARE), "material.shear_modulus = None"),
    (lambda: pressed(material=stiffer(1.0, 2.0)), "material.contact_stiffness: k ~ A"),
    (lambda: pressed(model="persson"), 'patch_area = None: model = "persson" needs'),
    (lambda: pressed(**PERSSON, regime="mixed"), 'model = "gw"'),
    (lambda: pressed().interface.temperature(), "kelvin = None"),
    (lambda: stiffer(1.0, 0.5, shear_modulus=1e9), "contact_stiffness: given twice"),
    (lambda: origins.moments_of_summits(radius=0.0, std=1.0, density=1.0), "radius"),
    (lambda: separated(1.0, BARE, regime="mixed"), "material.hardness = None"),
    (lambda: pressure_at(1e-4), "where no summit reaches"),
    (lambda: origins.gw_gaussian(2e6, 1.0), "separation = 2000000.0: is h0/sigma_h"),
    (lambda: origins.gw_gaussian(1.0, 1.0, "paper", "mixed"), "plasticity_index = None"),
    (lambda: moments(HEIGHTS), "pixel_size = None"),
    (lambda: moments(np.where(HEIGHTS > 0.5, np.nan, HEIGHTS), 1.0), "less than half"),
    (lambda: moments(HEIGHTS, 1.0, periodic=True), 'detrend = "centre"'),
    (lambda: moments(Scan(HEIGHTS, (1.0, 1.0), None)), "heights.unit = None"),
    (lambda: moments(Scan(HEIGHTS, (1.0, 1.0), ("µm", None))), "one unit"),
    (lambda: origins.moments_of_spectrum([1.0, 2.0], [1.0, 0.0]), "power[1] = 0.0"),
    (lambda: origins.moments_of_spectrum([1.0, 2.0], [1.0, 1.0], "2d"), "convention = '2d'"),
    (lambda: surface(hurst=1.2), "hurst = 1.2"),
    (lambda: surface(short_cutoff=100.0, long_cutoff=200.0), "no mode"),
    (lambda: surface(shape=(10**6, 10**6)), "needs 4e+04 GB, 40 bytes a point, and this"),
    (lambda: origins.from_samples(), "from_samples: give either x_s"),
    (lambda: origins.from_samples([]), "x_s = []: is empty: give one number at least"),
    (lambda: origins.from_samples([1.0, np.nan]), "x_s[1] = nan:"),
    (lambda: origins.from_samples(f_s=[1.0]), "from_samples: with f_s give either"),
    (
        lambda: origins.from_samples(f_s=[1.0], stiffness=[1.0, 1.0]),
        "stiffness = array of shape (2,): must hold",
    ),
    (
        lambda: origins.from_samples([1.0, 2.0], weights=[1.0, 0.0]),
        "weights[1] = 0.0: must be above zero",
    ),
    (lambda: origins.bootstrap(origins.gaussian(1.0, 0.1), len), "thresholds ="),
    (lambda: rotated(), "domains: give exactly one of sizes"),
    (lambda: rotated(sizes=[(3, 3)], weights=[1.0, 1.0]), "weights = [1.0, 1.0]:"),
    (lambda: rotated(islands=["a"], lattice_constant=None), "atoms = 'a':"),
    (
        lambda: rotated(islands=[PAIR], bonds=0.02, angles=[0.3], lattice_constant=None),
        "bonds = 0.02: lets the island's shape jump",
    ),
    (
        lambda: rotated(mean_atoms=5.0, angles=[0.0, 20.0]),
        "angles[1] = 20.0: angles are in radians, 2 pi",
    ),
    (
        lambda: rotated(mean_atoms=5.0, substrate=origins.fourier_substrate([[1.0, 1.0]], [1.0])),
        "substrate: varies in",
    ),
    (lambda: origins.barrier(ISLAND, [0.0, 20.0]), "angle[1] = 20.0: angles are in radians, 2 pi"),
    (lambda: origins.triangular_island(0.0, 3, 3), "lattice_constant = 0.0:"),
    (lambda: origins.triangular_island(2.5, 100_000, 100_000), "n_i = 100000:"),
    (lambda: origins.barrier(EMPTY, 0.0), "atoms = Atoms("),
    (lambda: origins.fourier_substrate([[1, 2], [-3, -6]], [1, 1]).cell, "all parallel"),
    (lambda: origins.relaxed_barrier(FIXED, ON), "FixAtoms does not fix"),
    (lambda: origins.relaxed_barrier(ISLAND, origins.square_substrate()), "ASE calculator"),
    (lambda: origins.relaxed_barrier(ISLAND, LEVEL), "all parallel"),
    (
        lambda: origins.relaxed_barrier(origins.triangular_island(2.5, 40, 40), ON, rigid=False),
        "at most 1500",
    ),
    (
        lambda: origins.relaxed_barrier(ISLAND, Wrong(np.nan), periods=6.3 * np.eye(2)),
        "calculator = nan: must give finite",
    ),
    (
        lambda: origins.relaxed_barrier(ISLAND, Wrong(1.5), periods=2.0 * np.pi * np.eye(2)),
        "forces must be those of its",
    ),
    (lambda: origins.relaxed_barrier(ISLAND, Wrong(1.0)), "periods = None: must be given"),
    (
        lambda: origins.relaxed_barrier(ISLAND, Wrong(1.0), periods=3.0 * np.eye(2)),
        "must leave energies",
    ),
    (lambda: origins.harmonic_bonds(ISLAND, 1.0, reach=1.0), "reach = 1.0: bonds no atoms"),
    (lambda: origins.grains(2.0 / 3.0, B=1.0), "rho = 0.6666666666666666: no grain pins yet"),
    (
        lambda: origins.grains(alpha=1.0, time=0.2, B=1.0),
        "time = 0.2: no grain pins yet: the first does",
    ),
    (
        lambda: origins.GrainGrowth(alpha=1.0, B=1.0).rho([1.0, 0.0]),
        "time = 0.0: must be finite and above zero",
    ),
    (lambda: Unbound().sf([0.5, 0.1]), "Unbound: its survival at x = 0.1 is 1.1, outside 0 to 1"),
    (lambda: Half().sf(0.5), "Half: its density adds up to 0.5, not to 1; state it as"),
    (lambda: origins.identical(0.0), "value = 0.0:"),
    (lambda: origins.gaussian(1.0, -0.1), "std = -0.1:"),
    (lambda: origins.gaussian(1.0, 0.1, form="paper", upper=0.9), "mean = 1.0:"),
    (lambda: origins.rectangular(1.0, 1.0), "upper = 1.0:"),
    (lambda: origins.gw_plastic(True), "B = True:"),
    (
        lambda: origins.lubricated(1.0, power=-1.0),
        "power = -1.0: must be above -1, or P_c has no norm",
    ),
    (lambda: origins.persson(101.0, 1.0), "centre = 101.0: is more than 100 widths"),
    (lambda: origins.mixture([origins.identical(1.0)] * 2, [0.5, 0.4]), "weights = [0.5, 0.4]:"),
    (lambda: origins.mixture([origins.identical(1.0), 3.0], [0.5, 0.5]), "thresholds = 3.0:"),
    (
        lambda: origins.continuous_mixture(origins.gw_plastic, 1.0, 0.0),
        "upper = 0.0: must be above lower = 1",
    ),
    (
        lambda: origins.continuous_mixture(lambda phi: origins.identical(phi), 1.0, 2.0),
        "values and jumps that move with phi",
    ),
    (
        lambda: origins.continuous_mixture(
            lambda phi: origins.rectangular(phi, 1.0 + phi), 0.0, 1.0
        ),
        "accuracy = 1e-10: 512 laws",
    ),
    (lambda: Contacts(stats.halfcauchy()), "thresholds: the mean is inf"),
    (lambda: Contacts(stats.norm(0.0, 1.0)), "weight 0.5 at or below x = 0"),
    (lambda: Contacts(stats.norm([1.0, 2.0], 0.1)), "arrays as parameters"),
    (lambda: Contacts(stats.gamma), "lacks its parameters"),
    (lambda: Contacts(stats.Normal(mu=0.0, sigma=1.0)), "weight 0.5 at or below x = 0"),
    (lambda: Contacts(1.0), "must come from origins"),
    (lambda: Contacts(origins.identical(1e-200)), "thresholds: the mean is 1e-200: powers of"),
    (
        lambda: Contacts(origins.gaussian(1e-100, 2e-101)),
        "thresholds: the mean is 1e-100: powers of",
    ),
    (lambda: Contacts(origins.gaussian(1e105, 2e104)), "thresholds: the mean is 1e+105: powers of"),
    (
        lambda: Contacts(BOX, start=-1.0),
        "start: a weight of 1 lies beyond every threshold, at |x| >= 1;",
    ),
    (
        lambda: Contacts(BOX, start=origins.gaussian_start(0.0, 0.21)),
        "start: a weight of 1.92e-06 lies",
    ),
    (lambda: Contacts(GAUSSIAN, start=np.nan), "start = nan:"),
    (lambda: Contacts(GAUSSIAN, start=stats.cauchy()), "start: the mean of the distribution is"),
    (lambda: Contacts(GAUSSIAN, thermal=0.1), "thermal = 0.1: must be an origins.Thermal"),
    (lambda: Contacts(GAUSSIAN, thermal=origins.RateLaw), "or of a subclass of RateLaw"),
    (lambda: Contacts(GAUSSIAN, stiffness="equal"), "stiffness = 'equal':"),
    (lambda: Contacts(GAUSSIAN, reforming="relaxed"), "reforming = 'relaxed': must be None, a"),
    (
        lambda: Contacts(GAUSSIAN, stiffness="linked", thermal=PAPER),
        "stiffness = 'linked': not defined with thermal closure",
    ),
    (
        lambda: Contacts(GAUSSIAN, ageing=Ageing(BOX, rate=1.0, closure="paper")),
        "ageing: a weight of 0.506 of the fresh",
    ),
    (lambda: Contacts(GAUSSIAN).replace(heat=0.1), "heat = 0.1: is not what contacts have;"),
    (lambda: origins.gaussian_start(0.0, -0.1), "std = -0.1:"),
    (lambda: origins.boltzmann_reforming(0.0), "temperature = 0.0: must be above zero"),
    (lambda: Delay(-0.1), "time = -0.1: must be zero or above"),
    (lambda: Thermal("weak", 0.1), "law = 'weak':"),
    (lambda: Thermal("soft", 0.0), "temperature = 0.0: must be above zero"),
    (
        lambda: Thermal("soft", 0.1).rate([0.5, 1.1], 1.0),
        "x = 1.1: a contact holds only where |x| is at most",
    ),
    (
        lambda: Thermal("stiff", 0.1).inverse([1.0, -2.0], 1.0),
        "amount = -2.0: must be zero or above",
    ),
    (lambda: Ageing(GAUSSIAN, -1.0), "rate = -1.0: must be zero or above"),
    (lambda: Ageing(origins.identical(1.5), 1.0), "final: holds the single value 1.5:"),
    (lambda: Ageing(GAP, 1.0), "final: has no weight between 0.5 and 1:"),
    (lambda: Drive([0.0, np.nan, 1.0]), "path[1] = nan:"),
    (lambda: Drive([0.0, 1.0], slip="instant"), "slip = 'instant': is what a slip of a soft"),
    (lambda: Drive([0.0, 1.0], mass=1.0), "mass = 1.0: is of a soft slider; give its spring"),
    (lambda: Drive([0.0, 1.0], spring=1.0, mass=0.0), "mass = 0.0: must be above zero"),
    (
        lambda: Drive([0.0, 1.0], spring=1.0, mass=1e101),
        "mass = 1e+101: must lie between 1e-100 and 1e+100",
    ),
    (
        lambda: Drive([0.0, 1.0], damping=1.0),
        "damping = 1.0: is of a slider with mass; give a mass, too",
    ),
    (
        lambda: Drive([0.0, 1.0], spring=1.0, damping=1.0),
        "damping = 1.0: is of a slider with mass; give a mass, too",
    ),
    (
        lambda: Drive([0.0, 1.0], spring=1.0, mass=1.0, damping=-0.1),
        "damping = -0.1: must be zero or above",
    ),
    (
        lambda: Drive([0.0, 1.0], spring=1.0, mass=1.0, slip="reset"),
        "slip = 'reset': mass, damping and the contacts' delay",
    ),
    (
        lambda: master.solve(Contacts(GAUSSIAN, thermal=PAPER), [1e5], spring=1.0, mass=1.0),
        "path[-1] = 100000.0: a slider with mass goes on by",
    ),
    (
        lambda: simulate(spring=1.0, mass=1.0, laws={"thermal": PAPER}),
        'contacts.thermal: closure = "paper" is an approximation',
    ),
    (
        lambda: simulate(spring=1.0, mass=1.0, laws={"reforming": 0.1}),
        "with a mass takes contacts that form again at x = 0; leave out reforming, or the mass",
    ),
    (lambda: simulate([0.0, 1.0, 0.5], spring=1.0, mass=1.0), "path[2] = 0.5: lies behind path[1]"),
    (
        lambda: simulate([0.0, 1.0], spring=1.0, mass=1.0, slip_fraction=2.0),
        "slip_fraction = 2.0: must be at most 1",
    ),
    (
        lambda: simulate([1e9], spring=1.0, mass=1.0, n_contacts=1000),
        "path[-1] = 1000000000.0: takes 1.0e+12 breaks of 1000",
    ),
    (
        # a slip from F_s = 0.69 on, though the spring could bear a mean threshold yet
        lambda: simulate([8e7], spring=1e-8, mass=0.01, n_contacts=1_000_000),
        "path[-1] = 80000000.0: takes 1.1e+13 breaks of 1000000",
    ),
    (
        lambda: simulate([1e12], spring=1.0, mass=1.0),
        "path[-1] = 1000000000000.0: must be below 8.59e+09",
    ),
    (lambda: simulate([1.0], spring=1e-15, mass=1.0), "spring = 1e-15: must be above"),
    (
        lambda: simulate([1.0], spring=1.0, mass=1e-30),
        "mass = 1e-30: oscillates 2.3e+14 times between two points",
    ),
    (
        lambda: simulate([0.0], time=[0.0], spring=1.0, mass=1.0, laws={"start": 0.1}),
        "path[0] = 0.0: leaves no time to get there",
    ),
    (lambda: Drive([0.0, 1.0], time=[0.0, 0.0]), "time[1] = 0.0: leaves no time to get there"),
    (lambda: Drive([0.0, 1.0], 2.0, time=[0.0, 1.0]), "velocity = 2.0: the times of the points"),
    (lambda: master.kinetic_curve(Contacts(GAUSSIAN), None), "velocity = nan: must be finite"),
    (
        lambda: master.phase_line(Contacts(GAUSSIAN), 1e300),
        "velocity = 1e+300: must lie between 1e-100 and 1e+100",
    ),
    (
        lambda: master.solve(Contacts(GAUSSIAN), [1.0, 0.5], time=[1e-310, 1.0]),
        "time[0] = 1e-310: leaves no time",
    ),
    (
        lambda: master.steady_state(Contacts(GAUSSIAN, ageing=AGEING), velocity=1e-20),
        "relaxes thresholds 1e10 times while",
    ),
    (
        lambda: master.solve(
            Contacts(GAUSSIAN, thermal=PAPER), [0, 0, 1], time=[0, 1e12, 1e12 + 1]
        ),
        "time[-1] = 1000000000001.0:",
    ),
    (
        lambda: master.critical_velocity(Contacts(GAUSSIAN, ageing=AGEING), 1.0, 2.0, 1.0),
        "slowest = 2.0: must be below fastest = 1",
    ),
    (
        lambda: simulate(laws={"reforming": 1.0 - 1e-12}, law=origins.identical(1.0)),
        "reforming: each contact breaks about 1e+12 times",
    ),
    (lambda: simulate(n_contacts=0), "n_contacts"),
    (lambda: simulate(n_contacts=2**40), "n_contacts"),
    (lambda: simulate(seed=-1), "seed"),
    (lambda: simulate([0.0, np.nan]), "path"),
    (lambda: simulate([0.0, 1e12]), "path"),
    (
        lambda: simulate(np.linspace(0.0, 1.0, 2001), histograms=np.arange(2001)),
        "must be at most 2000",
    ),
    (lambda: simulate(time=[0.0, -1.0]), "time"),
    (lambda: simulate(comm=3), "comm = 3: must be a communicator of mpi4py"),
    (lambda: simulate(laws={"thermal": PAPER}), "thermal"),
    (lambda: simulate(laws={"ageing": Ageing(GAUSSIAN, 0.1, closure="paper")}), "ageing"),
    (
        lambda: simulate(law=origins.rectangular(0.6, 0.9), laws={"ageing": Ageing(BOX, 0.1)}),
        "ageing: the final law ends at 0.5 and 1",
    ),
    (
        lambda: simulate(laws={"thermal": Thermal("soft", 1.0, 1e12)}),
        "each contact breaks about 6e+11 times",
    ),
    (lambda: simulate(laws={"thermal": Thermal("soft", 1e-21)}), "leave thermal out"),
    (
        lambda: simulate(laws={"reforming": 8.5}),
        "the survival of the thresholds is below 1e-290; use stretches",
    ),
    (
        lambda: simulate(law=stats.pareto(2.5), laws={"stiffness": "linked"}),
        "thresholds: stretches may reach",
    ),
    (lambda: simulate(law=Careless()), "the quantiles cannot be tabulated to 1e-6"),
    (lambda: simulate(slip="instant"), "rigid"),
    (lambda: simulate(slip_fraction=0.2), "slip_fraction"),
    (lambda: simulate(spring=-1.0), "spring"),
    (lambda: simulate(spring=0.7, slip="never"), "slip"),
    (lambda: simulate(spring=0.7, tolerance=1e-3), "tolerance"),
    (
        lambda: simulate([0.0, 2.0, 1.0], spring=0.7, mass=1.0),
        "the way back makes, too; use master.solve",
    ),
    (
        lambda: simulate([2.0, 1.0], spring=0.7, mass=1.0, laws={"stiffness": "linked"}),
        "which the way back makes, too",
    ),
    (lambda: simulate(spring=0.7, slip="reset", laws={"reforming": 0.1}), "reforming"),
]


@pytest.mark.parametrize(
    ("call", "says"),
    # some second, in which so many laws are made
    [slow(call, says, id=says, when="512 laws" in says) for call, says in REFUSED],
)
def test_it_is_refused_in_one_line(call: Callable[[], object], says: str) -> None:
    with pytest.raises(origins.InputError) as caught:
        call()
    assert says in str(caught.value) and "\n" not in str(caught.value)


# -- scenes -----------------------------------------------------------------------------------------

SCENE = scene(drive={"to": 5.0, "points": 501}, eq={"contacts": 100, "replicas": 2, "seed": 1})
SCENE["contacts"] |= {"start": {"kind": "gaussian", "mean": 0.0, "std": 0.025}}
SCENE["contacts"] |= {"thermal": {"law": "soft", "temperature": 0.3}}
SUMMIT = ROUGH["surface"]
GROWN = {"kind": "self-affine", "shape": [16, 16], "pixel_size": 1e-8}
GROWN |= {"hurst": 0.8, "rms_slope": 0.1}
ISLANDS = {"kind": "domains", "lattice_constant": 3.88, "mean_atoms": 100.0}
SMALL = {"kind": "triangular", "lattice_constant": 2.5, "n_i": 2, "n_j": 2}
OWN = {"kind": "domains", "stiffness": 1.0, "island": SMALL}
FALLING = {"contact_modulus": 1e11, "local_friction": 0.1}
FALLING |= {"contact_stiffness": {"kind": "power-law", "coefficient": 1.0, "exponent": -1.0}}
OLD = {"kind": "gaussian", "mean": 2.0, "std": 0.5}
SPEEDS = {"from": 1e-2, "to": 1e2, "points": 5}
LEFT_OUT = None

# a key of SCENE, the value it gets, and what is said; LEFT_OUT takes it out
WRONG: list[tuple[str, Any, str]] = [
    ("contacts.thresholds.std", -1.0, "contacts.thresholds.std = -1.0: must be above zero"),
    ("contacts.thresholds.mean", "one", "contacts.thresholds.mean = 'one': must be a number"),
    (
        "contacts.thresholds.width",
        1.0,
        "contacts.thresholds.width = 1.0: unknown key; gaussian takes mean, std",
    ),
    (
        "contacts.thresholds.mean",
        LEFT_OUT,
        "contacts.thresholds.mean: is missing; gaussian takes mean, std",
    ),
    (
        "contacts.thresholds.kind",
        "gausian",
        "contacts.thresholds.kind = 'gausian': did you mean gaussian? must be one of identical, gau",
    ),
    (
        "contacts.delays",
        {"time": 1.0},
        "contacts.delays: unknown key; did you mean delay? known here: thr",
    ),
    (
        "drive.wall_time",
        60.0,
        "drive.wall_time: unknown key; it stands before all tables; known here: poi",
    ),
    ("contacts.delay", "10 s", "contacts.delay = '10 s': must be a table, [contacts.delay] or de"),
    (
        "drive.delay",
        1.0,
        "drive.delay: unknown key; it is a table of its own, [contacts.delay]; known here: poi",
    ),
    ("contacts.area", 1e-6, "contacts.area: unknown key; it stands in [drive]; known here: thr"),
    (
        "contacts.thresholds.area",
        1e-6,
        "contacts.thresholds.area = 1e-06: unknown key; it stands in [drive]; gaussian takes mean, std",
    ),
    (
        "contacts.kelvin",
        300.0,
        "contacts.kelvin: unknown key; temperature = { kelvin = 300.0 } stands in [contacts.thermal]; ",
    ),
    (
        "contacts.rate",
        1.0,
        "contacts.rate: unknown key; it stands in [contacts.ageing]; known here",
    ),
    (
        "contacts.thresholds.std",
        "0,4",
        "contacts.thresholds.std = '0,4': must be a number alone, in the scene's unit of length, m of "
        "a surface; write 0.4, with a point",
    ),
    ("drive.to", "0,4", "drive.to = '0,4': must be a number alone, in the scene's unit of length"),
    ("drive.velocity", 0.0, "drive.velocity = 0.0: must be a number above 0, in m/s where le"),
    ("contacts.delay", {}, "contacts.delay.time: is missing; it takes time"),
    (
        "contacts.thermal",
        {"temperature": 0.1},
        'contacts.thermal.law: is missing; must be "soft", "stiff" or "eyring"; it takes law, ',
    ),
    (
        "contacts.ageing",
        {"rate": 0.1},
        "contacts.ageing.final: is missing; must be a table whose kind is one of identical, gaussian, ",
    ),
    (
        "contacts.thresholds",
        {"kind": "from-topography", "surface": {}, "material": {}, "law": "paper"},
        'contacts.thresholds.model: is missing; must be "gw" or "persson"; from-topography takes ',
    ),
    (
        "contacts.thresholds",
        {"kind": "from-topography", "surface": {}, "material": {}, "law": "paper", "model": "gw"},
        "contacts.thresholds.pressure: is missing; give a number in Pa, such as pressure = 1e6; from-to",
    ),
    (
        "contacts.thermal",
        {"law": "weak", "temperature": 0.1},
        "contacts.thermal.law = 'weak': must be \"soft\"",
    ),
    ("eq.contacts", 2.5, "eq.contacts = 2.5: expected a whole number"),
    (
        "contacts.thermal",
        {"law": "soft", "temperature": {"kelvin": -5.0}},
        "contacts.thermal.temperature.kelvin = -5.0: must be above zero; for T = 0 leave [contacts.thermal] out",
    ),
    (
        "contacts.thermal",
        {"law": "soft", "temperature": 0.0},
        "contacts.thermal.temperature = 0.0: must be above zero; for T = 0 leave [contacts.thermal] out",
    ),
    (
        "contacts.thermal",
        {"law": "soft", "kelvin": 300.0},
        "contacts.thermal.kelvin = 300.0: write temperature = { kelvin",
    ),
    (
        "contacts.thermal.temperature",
        {"kelvin": 300.0},
        "contacts.thermal.temperature.kelvin = 300.0: needs",
    ),
    (
        "contacts.ageing",
        {"rate": 1.0, "final": OLD | {"std": 0.0}},
        "contacts.ageing.final.std = 0.0: must be above",
    ),
    (
        "contacts.reforming",
        {"kind": "identical", "value": 9.0},
        "contacts.reforming: a weight of 1 lies beyond",
    ),
    (
        "contacts.stiffness",
        "linkd",
        'contacts.stiffness = \'linkd\': must be "independent" or "linked"',
    ),
    ("drive.to", -5.0, "drive.to = -5.0: must be a number above 0"),
    ("drive.to", True, "drive.to = True: expected a number"),
    ("drive.turns", [2.0, "a"], "drive.turns[1] = 'a': expected a number"),
    ("drive.points", 1, "drive.points = 1: expected a whole number >= 2"),
    (
        "drive",
        {"points": 11},
        "drive: needs one of to and turns, such as to = 5.0 or turns = [3.0, -3.0, 3.0]; neither",
    ),
    ("drive", {"points": 3, "turns": [1.0, -1.0, 1.0]}, "drive.points = 3"),
    (
        "drive",
        {"points": 11, "turns": [1.0, 1.0]},
        "drive.turns = [1.0, 1.0]: has a leg of no length",
    ),
    ("drive", {"points": 11, "to": 5e6}, "1e6 mean thresholds at most, or leave [eq] out"),
    (
        "drive",
        {"points": 11, "to": 1.0, "from": 0.5, "times": [1.0]},
        "for drive.from and each of drive.turns, 2",
    ),
    (
        "drive",
        {"points": 11, "to": 1.0, "times": [1.0], "velocity": 2.0},
        "drive.velocity = 2.0: the times of",
    ),
    ("drive", {"points": 11, "to": 1.0, "hold_scale": 1.0}, "drive.hold_scale = 1.0"),
    ("drive.spring", 0.0, "drive.spring = 0.0: must be a number above 0"),
    ("drive.spring", 1e160, "drive.spring = 1e+160: must lie between 1e-100 and 1e+100"),
    (
        "drive.slip",
        "instant",
        "drive.slip = 'instant': is what a slip of a soft slider does; without spring",
    ),
    ("master.tolerance", 0.0, "master.tolerance = 0.0: must be a number above 0"),
    ("eq.seed", -1, "eq.seed = -1: expected a whole number >= 0"),
    (
        "eq.thread",
        2,
        "eq.thread: unknown key; did you mean threads? known here: contacts, replicas, seed, tol",
    ),
    (
        "eq.histograms",
        [1.0, 2.005],
        "eq.histograms[1] = 2.005: is none of the path's points; near it are 2",
    ),
    (
        "eq.histogram_times",
        [1.0],
        "eq.histogram_times = [1.0]: are of a path with drive.times; without them say",
    ),
    ("wall_time", 0.0, "wall_time = 0.0: must be a number above 0"),
    ("title", "a\0b", "title"),
    ("colour", "red", "colour: unknown key; known here: contacts, drive, title, master, eq,"),
    ("sweep", {}, "sweep: goes along nothing"),
    ("sweep", {"velocity": "fast"}, "sweep.velocity = 'fast': expected a number | table | array"),
    ("sweep", {"velocity": [1.0, 0.0]}, "sweep.velocity[1] = 0.0: must be a number above 0"),
    (
        "sweep",
        {"velocity": SPEEDS | {"from": 0.0}},
        "sweep.velocity.from = 0.0: must be above zero",
    ),
    (
        "sweep",
        {"velocity": SPEEDS | {"spacing": "wide"}},
        'sweep.velocity.spacing = \'wide\': must be "log" or "even"',
    ),
    (
        "sweep",
        {"temperature": SPEEDS | {"from": 0.0}},
        'sweep.temperature: 0 has no logarithm; write spacing = "e',
    ),
    (
        "sweep",
        {"rate": [0.0, 1.0]},
        "sweep.rate: the contacts have no law for it; add [contacts.ageing]",
    ),
    ("sweep", {"kelvin": [1.0, 2.0]}, "sweep.kelvin: needs <k> in N/m"),
    (
        "sweep",
        {"velocity": [1.0, 2.0], "delay": [1.0, 2.0], "temperature": [1.0, 2.0]},
        "one or two of the keys must have",
    ),
    (
        "sweep",
        {"velocity": SPEEDS | {"points": 1000}, "delay": SPEEDS | {"points": 1000}},
        "sweep: has 1,000,000 points",
    ),
    (
        "contacts.thresholds",
        ROUGH | {"law": "strength"},
        'material.shear_strength: is missing; law = "strength" needs it',
    ),
    (
        "contacts.thresholds",
        ROUGH | {"material": FALLING},
        "material.contact_stiffness.exponent = -1.0: must lie between",
    ),
    (
        "contacts.thresholds",
        ROUGH | {"pressure": 1e12},
        'or take the thresholds of model = "persson"',
    ),
    (
        "contacts.thresholds",
        ROUGH | {"surface": GROWN | {"seed": 1}, "detrend": "tilt"},
        'write detrend = "centre"',
    ),
    (
        "contacts.thresholds",
        ROUGH | {"step": 2},
        "contacts.thresholds.step = 2: belongs to heights",
    ),
    (
        "contacts.thresholds",
        ROUGH | {"surface": SUMMIT | {"step": 2}},
        "contacts.thresholds.surface.step = 2: unknown key; it stands beside surface, not in it; summits",
    ),
    (
        "contacts.thresholds",
        ROUGH | {"surface": SUMMIT | {"radius": 1e-300}},
        "some of its numbers are too large or too",
    ),
    ("contacts.thresholds", ROUGH, "did you mean temperature = { kelvin = 0.3 }"),
    (
        "contacts",
        {"thresholds": ROUGH, "thermal": {"law": "soft", "temperature": {"kelvin": 300.0}}},
        "contacts.thermal.attempt_frequency: is missing",
    ),
    (
        "contacts.thresholds",
        ISLANDS,
        'stiffness: is missing; law = "area" needs it; for lengths in units of your own write',
    ),
    (
        "contacts.thresholds",
        ISLANDS | {"sizes": [[7.0, 9.0]]},
        "domains: give exactly one of sizes, such as [[10, 9]]",
    ),
    (
        "contacts.thresholds",
        OWN | {"lattice_constant": 2.5},
        "contacts.thresholds.lattice_constant = 2.5: the table",
    ),
    (
        "contacts.thresholds",
        OWN | {"island": {"kind": "file", "file": "no.xyz"}},
        "island.file = 'no.xyz': no such file",
    ),
    (
        "contacts.thresholds",
        OWN | {"bonds": 1.0},
        "bonds = 1.0: makes islands of your own flexible, at listed",
    ),
    (
        "contacts.thresholds",
        {"kind": "mixture", "components": [1.0], "weights": [1.0]},
        "must be a list of tables, such as",
    ),
    (
        "contacts.thresholds",
        {"kind": "gaussian", "mean": 1.0, "std": 0.1, "form": "paper"},
        "upper: is missing; form =",
    ),
    (
        "contacts.thresholds",
        {"kind": "rectangular", "lower": 1.0, "upper": 1.0},
        "for one value take identical, value = 1",
    ),
    (
        "contacts.thresholds",
        {"kind": "from-samples", "file": "none.txt"},
        "file = 'none.txt': no such file: /",
    ),
]


def test_a_missing_file_is_told_with_its_key_its_place_and_what_to_write(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scan = {"kind": "scan", "file": "../scan.di"}
    thresholds = ROUGH | {"surface": scan}
    monkeypatch.chdir(tmp_path)
    Path("own").mkdir()
    place = Path("scan.di").resolve()
    file = Path(write("own/mine", thresholds=thresholds))
    for made, says in ((False, "no such file: "), (True, "is no plain scan")):
        with pytest.raises(origins.InputError) as caught:
            toolkit.load_scene(file)
        told = str(caught.value)
        assert told.startswith("contacts.thresholds.surface.file = '../scan.di': ") and says in told
        assert str(place) in told
        assert ("write its path from the folder of the scene" in told) is not made
        if not made:
            os.mkfifo(place)


@pytest.mark.parametrize(("place", "value", "says"), WRONG, ids=[says for *_, says in WRONG])
def test_a_scene_is_refused_by_the_path_of_its_key(place: str, value: Any, says: str) -> None:
    *tables, key = place.split(".")
    table = scene = copy.deepcopy(SCENE)
    for name in tables:
        table = table.setdefault(name, {})
    table[key] = value
    if value is LEFT_OUT:
        del table[key]
    with pytest.raises(origins.InputError) as caught:
        toolkit.load_scene(scene)
    told = str(caught.value)
    assert says in told and "\n" not in told
    # no calls, no arguments as Python writes them, no values that TOML has not
    if "thresholds" in place:
        assert not re.search(r"origins\.|\b\w+=|\b[a-z_]+\([^)]|\(\d|\bNone\b|PowerLaw", told), told

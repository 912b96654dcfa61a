"""What surfaces, islands, samples and grains refuse: a call a line, and how its one line begins."""

import numpy as np
import pytest
from ase import Atoms
from ase.constraints import FixAtoms, FixedLine

import origins

MATERIAL = origins.Material(
    contact_modulus=3e9,
    local_friction=0.4,
    shear_modulus=1.1e9,
    hardness=6e7,
    shear_strength=6e7,
    force_coefficient=2e10,
)
BARE = origins.Material(contact_modulus=1e9, local_friction=0.3)
SUMMITS = origins.moments_of_summits(radius=20e-6, std=0.2e-6, density=3e9)
ISLAND = origins.triangular_island(2.5, 2, 2)
HEIGHTS = np.random.default_rng(1).standard_normal((20, 20))
SAMPLES = origins.from_samples(np.linspace(0.3, 2.0, 50))
PERSSON = {"model": "persson", "patch_area": 1e-12}


class Scan:
    """What a topography object must offer."""

    def __init__(self, unit: object, pixel_size: tuple = (1.0, 1.0)) -> None:
        self.unit, self.pixel_size = unit, pixel_size

    def heights(self) -> np.ndarray:
        return HEIGHTS


def pressed(moments: origins.SpectralMoments = SUMMITS, **change: object) -> origins.Thresholds:
    """Greenwood and Williamson's thresholds under 1e5 Pa, but for what is changed."""
    asked = {"model": "gw", "law": "amontons", "material": MATERIAL, "pressure": 1e5}
    return origins.from_moments(moments, **(asked | change))


def stiffer(coefficient: float, exponent: float, **constants: float) -> origins.Material:
    law = origins.PowerLaw(coefficient, exponent)
    return origins.Material(
        contact_modulus=1e9, local_friction=0.3, contact_stiffness=law, **constants
    )


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


EMPTY, LOST, TWINS = Atoms(), Atoms("H", [[np.nan, 0.0, 0.0]]), Atoms("H2")
LINE, FIXED = ISLAND.copy(), ISLAND.copy()
LINE.set_constraint(FixedLine(0, [1, 0, 0]))
FIXED.set_constraint(FixAtoms(range(4)))
ON = origins.substrate_calculator(origins.square_substrate())
LEVEL = origins.substrate_calculator(origins.fourier_substrate([[1.0, 0.0]], [1.0]))
CONTACT = origins.GrainContact(origins.GrainGrowth(1.0, 1.0))

REFUSED = """
pressed(model="hertz")                                      model = 'hertz'
pressed(law="coulomb")                                      law = 'coulomb'
pressed(material={"E": 1.0})                                material = {'E': 1.0}
pressed(pressure=0.0)                                       pressure = 0.0
pressed(pressure=1e30)                                      summits would cover
pressed(pressure=1e9, height_law="exponential")             bear at most
pressed(height_law="flat")                                  height_law = 'flat'
pressed(patch_area=1e-12)                                   patch_area = 1e-12
pressed(regime="brittle")                                   regime = 'brittle'
pressed(regime="mixed", material=BARE)                      material.hardness = None
pressed(material=BARE)                                      material.shear_modulus = None
pressed(material=BARE, law="paper")                         material.force_coefficient = None
pressed(material=BARE, law="strength")                      material.shear_strength = None
pressed(material=origins.Material(contact_modulus=1e9))     material.local_friction = None
pressed(material=stiffer(1.0, 2.0))                         material.contact_stiffness: k ~ A
pressed(material=stiffer(1.0, 1.0, force_coefficient=1.0), law="paper")  material.contact_stiffness
pressed(model="persson")                                    patch_area = None: model = "persson" needs
pressed(**PERSSON, pressure=1e30)                           pressure = 1e+30
pressed(**PERSSON, regime="mixed")                          model = "gw"
pressed(**PERSSON, height_law="exponential")                height_law
pressed(**PERSSON, law="strength")                          model = 'gw'
pressed().interface.temperature()                           kelvin = None
pressed().interface.temperature(kelvin=1.0, energy=1.0)     kelvin = 1.0
origins.Material(contact_modulus=-1.0)                      contact_modulus = -1.0
origins.Material(contact_modulus=1.0, density=1.0)          sound_velocity = None
origins.Material(contact_modulus=1.0, contact_stiffness=3.0)  contact_stiffness = 3.0
stiffer(1.0, 0.5, shear_modulus=1e9)                        contact_stiffness: given twice
stiffer(1.0, -1.0)                                          contact_stiffness.exponent = -1.0
origins.PowerLaw(1.0, np.inf)                               exponent = inf
origins.sound_stiffness(-1.0, 1.0)                          density = -1.0
origins.mindlin_stiffness(1e9, 0.6)                         poisson_ratio = 0.6
origins.mindlin_stiffness((1e9, 1e9, 1e9), 0.3)             shear_modulus = (1000000000.0,
origins.column_stiffness(1e9)                               column_stiffness: give one of
origins.moments_of_summits(radius=0.0, std=1.0, density=1.0)  radius
origins.resolution_study(surface(), 1e-7, factors=(0,))     factors
separated(-1.0)                                             pressure = -1.0
separated(1.0, regime="both")                               regime = 'both'
separated(1.0, BARE, regime="mixed")                        material.hardness = None
pressure_at(np.nan)                                         separation = nan
pressure_at(-1e-4)                                          raise it
pressure_at(1e-4)                                           where no summit reaches
pressure_at(-1e-9, height_law="exponential")                every summit touches
origins.gw_gaussian(np.nan, 1.0)                            separation = nan
origins.gw_gaussian(2e6, 1.0)                               separation = 2000000.0: is h0/sigma_h
origins.gw_gaussian(1.0, 0.0)                               scale = 0.0
origins.gw_gaussian(2.0, 1e300)                             scale = 1e+300: must lie between
origins.gw_gaussian(1.0, 1.0, "coulomb")                    law = 'coulomb'
origins.gw_gaussian(1.0, 1.0, "paper", "hard")              regime = 'hard'
origins.gw_gaussian(1.0, 1.0, "paper", "mixed")             plasticity_index = None
origins.gw_gaussian(1.0, 1.0, "paper", "elastic", 2.0)      plasticity_index = 2.0: belongs to regime
moments(HEIGHTS)                                            pixel_size = None
moments(HEIGHTS, (1.0, -2.0))                               pixel_size[1] = -2.0
moments(HEIGHTS[0], 1.0)                                    two-dimensional
moments(HEIGHTS[:2], 1.0)                                   at least 3 points
moments(np.where(HEIGHTS > 2.0, np.inf, HEIGHTS), 1.0)      must be finite
moments(np.full((9, 9), np.nan), 1.0)                       every point is missing
moments(np.where(HEIGHTS > 0.5, np.nan, HEIGHTS), 1.0)      less than half
moments(np.ones((9, 9)), 1.0)                               flat surface
moments(HEIGHTS, 1.0, detrend="plane")                      detrend = 'plane'
moments(HEIGHTS, 1.0, periodic=True)                        detrend = "centre"
moments(HEIGHTS, 1.0, step=10)                              step = 10
moments(Scan(None))                                         heights.unit = None
moments(Scan(("µm", None)))                                 one unit
moments(Scan("nm"), 1.0)                                    leave it out
moments(Scan("nm", (1.0,)))                                 heights.pixel_size
origins.moments_of_spectrum([1.0], [1.0])                   wavevectors =
origins.moments_of_spectrum([1.0, 2.0], [1.0])              power =
origins.moments_of_spectrum([1.0, 2.0], [1.0, 0.0])         power[1] = 0.0
origins.moments_of_spectrum([2.0, 1.0], [1.0, 1.0])         wavevectors[1] = 1.0
origins.moments_of_spectrum([1.0, 2.0], [1.0, 1.0], "2d")   convention = '2d'
surface(hurst=1.2)                                          hurst = 1.2
surface(rms_slope=-0.1)                                     rms_slope = -0.1
surface(seed=2**64)                                         seed =
surface(shape=32)                                           shape = 32
surface(pixel_size=(1.0, 0.0))                              pixel_size[1] = 0.0
surface(long_cutoff=3.0, short_cutoff=4.0)                  long_cutoff = 3.0
surface(short_cutoff=100.0, long_cutoff=200.0)              no mode
surface(shape=(10**6, 10**6))                               needs 4e+04 GB, 40 bytes a point, and this
surface(shape=(10**200, 10**200))                           needs over 1e300 GB
origins.from_samples()                                      from_samples: give either x_s
origins.from_samples([])                                    x_s = array of shape (0,):
origins.from_samples("many")                                x_s = 'many':
origins.from_samples([1.0, np.nan])                         x_s[1] = nan:
origins.from_samples([1.0, -1.0])                           x_s[1] = -1.0:
origins.from_samples([1.0, 1e-101])                         x_s[1] = 1e-101: must lie between 1e-100 and
origins.from_samples([1.0], stiffness=2.0)                  stiffness = 2.0:
origins.from_samples([1.0], f_s=[1.0])                      from_samples: give either x_s
origins.from_samples(f_s=[1.0])                             from_samples: with f_s give either
origins.from_samples(f_s=[1.0], stiffness=0.0)              stiffness = 0.0:
origins.from_samples(f_s=[1.0], stiffness=[1.0, 1.0])       stiffness = array of shape (2,): must hold
origins.from_samples(f_s=[1.0, 1e-300], stiffness=1e50)     f_s[1] = 1e-300: makes a length of 0
origins.from_samples([1.0, 2.0], weights=[1.0])             weights = array of shape (1,): must hold one
origins.from_samples([1.0, 2.0], weights=[1.0, 0.0])        weights[1] = 0.0: must be above zero
origins.bootstrap(origins.gaussian(1.0, 0.1), len)          thresholds =
origins.bootstrap_laws(origins.identical(1.0), 3)           thresholds =
origins.bootstrap_laws(SAMPLES, 0)                          resamples = 0:
origins.bootstrap(SAMPLES, len, seed=-1)                    seed = -1:
origins.bootstrap(SAMPLES, lambda law: np.inf)              statistic = inf: must be finite
origins.bootstrap(SAMPLES, lambda law: np.ones(int(1e3 * law.mean())))  statistic =
rotated()                                                   domains: give exactly one of sizes
rotated(sizes=[(3, 3)], mean_atoms=10.0)                    domains: give exactly one of sizes
rotated(sizes=[(3, 3)], lattice_constant=None)              lattice_constant = None:
rotated(sizes=[[5, 5], [6]])                                sizes = [[5, 5], [6]]:
rotated(sizes=[(3, 3)], weights=[1.0, 1.0])                 weights = [1.0, 1.0]:
rotated(mean_atoms=1e13)                                    mean_atoms = 10000000000000.0:
rotated(mean_atoms=5.0, weights=[1.0])                      weights = [1.0]:
rotated(islands=[])                                         lattice_constant = 2.5:
rotated(islands=["a"], lattice_constant=None)               atoms = 'a':
rotated(mean_atoms=5.0, angles=[0.0, 20.0])                 angles[1] = 20.0: angles are in radians, 2 pi
rotated(mean_atoms=5.0, law="amontons")                     law = 'amontons':
rotated(mean_atoms=5.0, coefficient=1.0)                    coefficient = 1.0:
rotated(mean_atoms=5.0, law="paper")                        stiffness = 1.0:
rotated(mean_atoms=5.0, seed=-1)                            seed = -1:
rotated(mean_atoms=5.0, substrate=origins.fourier_substrate([[1.0, 1.0]], [1.0]))  substrate: varies in
rotated(sizes=[(2, 2)], lattice_constant=np.pi, angles=[0.0])  domains: none of 20000 islands has a bar
origins.barrier("atoms", 0.0)                               atoms = 'atoms':
origins.barrier(ISLAND, np.inf)                             angle[0] = inf:
origins.barrier(ISLAND, "20")                               angle = '20': must be in radians
origins.barrier(ISLAND, [0.0, 20.0])                        angle[1] = 20.0: angles are in radians, 2 pi
origins.barrier(ISLAND, 0.0, "square")                      substrate = 'square':
origins.triangular_barrier(1.0, 2, 2, -45.0)                angle = -45.0: angles are in radians, 2 pi
origins.triangular_island(0.0, 3, 3)                        lattice_constant = 0.0:
origins.triangular_island(2.5, 3, 2.5)                      n_j = 2.5:
origins.triangular_island(2.5, 100_000, 100_000)            n_i = 100000:
origins.circular_island(2.5, 1.0, lattice="cubic")          lattice = 'cubic':
origins.irregular_island(2.5, 5.0, roughness=4.0)           roughness = 4.0:
origins.barrier(EMPTY, 0.0)                                   atoms = Atoms(
origins.square_substrate(1.0, -1.0)                         period = -1.0:
origins.hexagonal_substrate(0.0)                            amplitude = 0.0:
origins.fourier_substrate([], [])                           wavevectors = array of shape (0,):
origins.fourier_substrate([[1.0, 0.0]], [1.0, 2.0])         coefficients = array of shape (2,):
origins.fourier_substrate([[1, 0], [-1, 0]], [1, -1])       wavevectors: nothing but a constant is left
origins.fourier_substrate([[1, 2], [-3, -6]], [1, 1]).cell  all parallel
origins.fourier_substrate([[1, 0], [2**0.5, 0], [0, 1]], [1, 1, 1]).cell  never repeats
origins.triangular_structure_factors(1.0, 0, 3, 0.0)        n_i = 0:
origins.triangular_structure_factors(1.0, [3, 4], 3, [0.0, 1.0, 2.0])  angle = array of shape (3,):
origins.triangular_structure_factors(1.0, 3, 3, 0.0, [1.0, 0.0])  wavevectors = array of shape (2,):
origins.relaxed_barrier(np.zeros((3, 3)), ON)               atoms = array of shape
origins.relaxed_barrier(LOST, ON)  finite positions
origins.relaxed_barrier(LINE, ON)  atoms.constraints =
origins.relaxed_barrier(FIXED, ON)  FixAtoms does not fix
origins.relaxed_barrier(ISLAND, origins.square_substrate())  ASE calculator
origins.relaxed_barrier(ISLAND, LEVEL)                      all parallel
origins.relaxed_barrier(ISLAND, ON, periods=[[1.0, 0.0], [2.0, 0.0]])  not parallel
origins.relaxed_barrier(ISLAND, ON, rigid=1)                rigid = 1: must be True or False
origins.relaxed_barrier(origins.triangular_island(2.5, 40, 40), ON, rigid=False)  at most 1500
origins.harmonic_bonds(ISLAND, 0.0)                         stiffness = 0.0: must be above zero
origins.harmonic_bonds(np.zeros(3), 1.0)                    atoms =
origins.harmonic_bonds(TWINS, 1.0)                in one place
origins.harmonic_bonds(ISLAND, 1.0, reach=1.0)              reach = 1.0: bonds no atoms
origins.grains(2.0 / 3.0, B=1.0)                            rho = 0.6666666666666666: no grain pins yet
origins.grains(1e60, B=1.0)                                 rho = 1e+60: must be at most 1e+50
origins.grains(1.0, B=1.0, time=1.0)                        rho = 1.0: is alpha time^(1/3): give rho, or
origins.grains(B=1.0)                                       rho = None: is missing; give rho, such as
origins.grains(alpha=1.0, B=1.0)                            time = None: is missing;
origins.grains(alpha=1.0, time=0.2, B=1.0)                  time = 0.2: no grain pins yet: the first does
origins.grains(1.0, B=0.0)                                  B = 0.0: must be above zero
origins.grains(1.0, B=1.0, jacobian="printed")              jacobian = 'printed': must be "exact" or
origins.GrainGrowth(alpha=-1.0, B=1.0)                      alpha = -1.0: must be above zero
origins.GrainGrowth(alpha=1.0, B=1.0).rho([1.0, 0.0])       time = 0.0: must be finite and above zero
origins.film_growth(2e-9, 1e-27, 1e8)                       give either force_coefficient or shear_modulus
origins.film_growth(-1.0, 1e-27, 1e8, 1.0)                  film_thickness = -1.0: must be above zero
CONTACT.quantile([0.5, np.nan], 1.0)                        u = nan: must be a quantile
CONTACT.quantile(0.5, [1.0, 0.1])                           age = 0.1: no grain pins before the age
origins.GrainContact(1.0)                                   growth = 1.0: must be growth
"""
ROWS = [line.split("  ", 1) for line in REFUSED.strip().splitlines()]


@pytest.mark.parametrize(("call", "says"), ROWS, ids=[call for call, _ in ROWS])
def test_it_is_refused_in_one_line(call: str, says: str) -> None:
    with pytest.raises(origins.InputError) as caught:
        eval(call)
    assert says.strip() in str(caught.value) and "\n" not in str(caught.value)

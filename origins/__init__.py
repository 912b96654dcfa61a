"""What one contact is, and how it is driven: thresholds and their origins, laws, starts, the drive."""

# ruff: noqa: F401
from origins.contacts import Contacts
from origins.domains.barriers import (
    barrier,
    structure_factors,
    triangular_barrier,
    triangular_structure_factors,
)
from origins.domains.calculators import harmonic_bonds, substrate_calculator
from origins.domains.islands import (
    circular_island,
    hexagonal_island,
    irregular_island,
    rectangular_island,
    square_island,
    triangular_island,
)
from origins.domains.relaxed_barrier import RelaxedBarrier, relaxed_barrier
from origins.domains.rotated import DomainSamples, domains
from origins.domains.substrates import (
    Substrate,
    fourier_substrate,
    hexagonal_substrate,
    square_substrate,
)
from origins.drive import Drive
from origins.errors import InputError
from origins.grains.contact import GrainContact, growing_grains
from origins.grains.film import GrainGrowth, film_growth, grains
from origins.laws.ageing import Ageing
from origins.laws.delay import Delay
from origins.laws.growing import GrowingThresholds
from origins.laws.ordered import OrderedThresholds
from origins.laws.proportional import ProportionalGrowth
from origins.laws.rate_law import RateLaw
from origins.laws.soft import SoftRates
from origins.laws.stiff import StiffRates
from origins.laws.strengthening import Strengthening, strengthening
from origins.laws.thermal import Thermal
from origins.laws.timed_law import ChangingThresholds
from origins.roughness.from_surface import from_moments, from_topography, resolution_study
from origins.roughness.greenwood_williamson import (
    gw_gaussian,
    pressure_of_separation,
    separation_of_pressure,
)
from origins.roughness.interface import (
    Interface,
    Material,
    column_stiffness,
    mindlin_stiffness,
    sound_stiffness,
)
from origins.roughness.moments import (
    SpectralMoments,
    moments_of_spectrum,
    moments_of_summits,
    spectral_moments,
)
from origins.roughness.stated import StatedInterface
from origins.roughness.surface import self_affine_surface
from origins.samples.from_samples import Bootstrapped, bootstrap, bootstrap_laws, from_samples
from origins.start import Start, boltzmann_reforming, gaussian_start
from origins.thresholds.families import (
    gw_elastic,
    gw_plastic,
    identical,
    lubricated,
    persson,
    rectangular,
)
from origins.thresholds.gaussian import gaussian
from origins.thresholds.law import ThresholdLaw, Thresholds
from origins.thresholds.mixture import continuous_mixture, mixture
from origins.thresholds.powered import PowerLaw

# the public names are all those imported above
__all__ = [name for name, found in globals().items() if hasattr(found, "__qualname__")]

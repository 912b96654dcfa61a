"""What one contact is and what is asked of it: thresholds, where they come from, starts, the drive."""

from origins.ageing import Ageing
from origins.barriers import barrier, triangular_barrier
from origins.bootstrap import Bootstrapped, bootstrap, bootstrap_laws
from origins.calculators import harmonic_bonds, substrate_calculator
from origins.contact_stiffness import column_stiffness, mindlin_stiffness, sound_stiffness
from origins.contacts import Contacts
from origins.continuous_mixture import continuous_mixture
from origins.delay import Delay
from origins.domains import DomainSamples, domains
from origins.drive import Drive
from origins.errors import InputError
from origins.gaussian import gaussian
from origins.grain_contact import GrainContact, growing_grains
from origins.grain_growth import GrainGrowth, film_growth
from origins.grains import grains
from origins.greenwood_williamson import pressure_of_separation, separation_of_pressure
from origins.gw_gaussian import gw_gaussian
from origins.identical import identical
from origins.interface import Interface
from origins.islands import (
    circular_island,
    hexagonal_island,
    irregular_island,
    rectangular_island,
    square_island,
    triangular_island,
)
from origins.laws import SoftRates, StiffRates
from origins.lubricated import lubricated
from origins.material import Material
from origins.mixture import mixture
from origins.persson import persson
from origins.power_law import PowerLaw
from origins.rate_law import RateLaw
from origins.rectangular import rectangular
from origins.reforming import boltzmann_reforming
from origins.relaxed_barrier import RelaxedBarrier, relaxed_barrier
from origins.rough_contact import from_moments, from_topography, resolution_study
from origins.samples import from_samples
from origins.self_affine import self_affine_surface
from origins.spectral_moments import SpectralMoments, moments_of_summits, spectral_moments
from origins.spectrum import moments_of_spectrum
from origins.start import Start, gaussian_start
from origins.structure_factors import structure_factors, triangular_structure_factors
from origins.substrates import Substrate, fourier_substrate, hexagonal_substrate, square_substrate
from origins.thermal import Thermal
from origins.threshold_law import ThresholdLaw
from origins.thresholds import Thresholds
from origins.weibull import gw_elastic, gw_plastic

__all__ = [
    "Ageing",
    "Bootstrapped",
    "Contacts",
    "Delay",
    "DomainSamples",
    "Drive",
    "GrainContact",
    "GrainGrowth",
    "InputError",
    "Interface",
    "Material",
    "PowerLaw",
    "RateLaw",
    "RelaxedBarrier",
    "SoftRates",
    "SpectralMoments",
    "Start",
    "StiffRates",
    "Substrate",
    "Thermal",
    "ThresholdLaw",
    "Thresholds",
    "barrier",
    "boltzmann_reforming",
    "bootstrap",
    "bootstrap_laws",
    "circular_island",
    "column_stiffness",
    "continuous_mixture",
    "domains",
    "film_growth",
    "fourier_substrate",
    "from_moments",
    "from_samples",
    "from_topography",
    "gaussian",
    "gaussian_start",
    "grains",
    "growing_grains",
    "gw_elastic",
    "gw_gaussian",
    "gw_plastic",
    "harmonic_bonds",
    "hexagonal_island",
    "hexagonal_substrate",
    "identical",
    "irregular_island",
    "lubricated",
    "mindlin_stiffness",
    "mixture",
    "moments_of_spectrum",
    "moments_of_summits",
    "persson",
    "pressure_of_separation",
    "rectangular",
    "rectangular_island",
    "relaxed_barrier",
    "resolution_study",
    "self_affine_surface",
    "separation_of_pressure",
    "sound_stiffness",
    "spectral_moments",
    "square_island",
    "square_substrate",
    "structure_factors",
    "substrate_calculator",
    "triangular_barrier",
    "triangular_island",
    "triangular_structure_factors",
]
